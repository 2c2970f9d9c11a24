"""A student who asks without end and waits for no answer: python -m tests.bench.flood ENDPOINT WORLD IDENTITY AGENT"""

from __future__ import annotations

import itertools
import os
import sys
import threading
from pathlib import Path
from typing import Any

import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.keys import Keys


def main() -> None:
    """Ask until standard input ends."""
    address, world, identity, agent = sys.argv[1:]
    session = link.open_session(link.Link(connect=(address,), identity=Path(identity)), threading.Event())
    assert session is not None
    keys = Keys(world)
    ended = threading.Event()

    def listen() -> None:
        sys.stdin.read()
        ended.set()

    threading.Thread(target=listen, daemon=True).start()
    print("ready", flush=True)
    for key in itertools.cycle((keys.map, keys.clock, keys.body(agent))):
        if ended.is_set():
            return
        ignored: Any = zenoh.handlers.Callback(lambda _reply: None, lambda: None)
        session.get(key, ignored, timeout=5.0)


if __name__ == "__main__":
    try:
        main()
    finally:
        # Sessions with callbacks hang at exit; nothing here is worth a clean end.
        os._exit(0)
