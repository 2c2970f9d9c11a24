"""`iw-record`: records a world, or shows it live."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.resources import files

from intellwheels_agents.options import OptionError
from intellwheels_agents.record_gateway import record_options
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.process import add_process_options, printing, stop_on_signals


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = record_options.parser()
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    given = parser().parse_args(arguments)
    # First, because a signal may arrive while the other arguments are read.
    stop = stop_on_signals(given.lifeline)
    try:
        if given.layout:
            return _print_layout()
        where = link_of(given)
        record_options.check_together(given)
        lacking = missing_extra(
            "foxglove", *(["ros"] if given.ros2 is not None else []), *(["server"] if given.log is not None else [])
        )
        if lacking is not None:
            _log(lacking)
            return 2
        from intellwheels_agents.record_gateway.record_process import record  # noqa: PLC0415 - needs the extra

        return record(given, where, stop)
    except (OptionError, WireError) as error:
        _log(str(error))
        return 2
    except OSError as error:
        _log(str(error))
        return 1


def _print_layout() -> int:
    with printing():
        sys.stdout.write(files("intellwheels_agents.record_gateway").joinpath("layout.json").read_text())
    return 0


def _log(line: str) -> None:
    print(f"iw-record: {line}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
