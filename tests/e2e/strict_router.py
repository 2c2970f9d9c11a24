"""A router whose access control lets nobody steer through it: `python -m tests.e2e.strict_router FILE`.

The file is a Zenoh configuration, see `write`; it is what `zenohd -c FILE` takes.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import zenoh

from intellwheels_schemas.process import SLICE, add_process_options, stop_on_signals
from intellwheels_schemas.router_link import router_settings


def write(path: Path, endpoint: str) -> Path:
    """Write the configuration: queries of `ctl` and what is put to `user` end at the router."""
    settings = json.loads(router_settings([endpoint]))
    settings["access_control"] = {
        "enabled": True,
        "default_permission": "allow",
        "rules": [
            {
                "id": "steering",
                "messages": ["query", "put"],
                "flows": ["ingress"],
                "permission": "deny",
                "key_exprs": ["iw/v1/*/ctl/**", "iw/v1/*/user/**"],
            }
        ],
        "subjects": [{"id": "everybody"}],
        "policies": [{"rules": ["steering"], "subjects": ["everybody"]}],
    }
    path.write_text(json.dumps(settings))
    return path


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    add_process_options(parser)
    options = parser.parse_args()
    stop = stop_on_signals(options.lifeline)
    with zenoh.open(zenoh.Config.from_file(str(options.file))):
        print("ready", flush=True)
        while not stop.wait(SLICE):
            pass


if __name__ == "__main__":
    main()
