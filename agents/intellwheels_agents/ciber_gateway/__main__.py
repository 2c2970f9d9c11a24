"""`iw-ciber`: lets agents and viewers of the Ciber-Rato simulator take part in a world."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from intellwheels_agents.ciber_gateway import ciber_options
from intellwheels_agents.ciber_gateway.ciber_process import CiberProcess
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import fields_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.process import add_process_options, stop_on_signals


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = ciber_options.parser()
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    given = parser().parse_args(arguments)
    # First, because a signal may arrive while the other arguments are read.
    stop = stop_on_signals(given.lifeline)
    try:
        where = link_of(given)
        ciber_options.check_together(given)
        changes = fields_of(given.option)
        ciber_options.check_fields(given, changes)
        return CiberProcess(given, where, changes, stop).run()
    except (OptionError, WireError) as error:
        _log(str(error))
        return 2
    except OSError as error:
        _log(str(error))
        return 1


def _log(line: str) -> None:
    print(f"iw-ciber: {line}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
