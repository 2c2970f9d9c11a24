"""The command lines of the trials: their help keeps the lines of the module's docstring and shows every default."""

from __future__ import annotations

import argparse
from pathlib import Path


def trial_parser(module: str, about: str | None, csv: Path | None = None) -> argparse.ArgumentParser:
    """Return the parser of `python -m MODULE`, described by the docstring of the module, with the option `--csv`.

    Args:
        module: The module.
        about: Its docstring.
        csv: The file that `--csv` names by default; None if rows are not written by default.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m {module}",
        description=(about or "").strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    default = "none" if csv is None else f"{csv.name}, which is kept beside the module"
    parser.add_argument(
        "--csv", type=Path, default=csv, metavar="FILE", help=f"write the rows to this CSV file (default: {default})"
    )
    return parser


def add_runs(parser: argparse.ArgumentParser, option: str, count: int, each: str) -> None:
    """Add the options that say which runs to make: their number, such as `--seeds`, and the first one."""
    parser.add_argument(option, type=int, default=count, metavar="N", help=f"number of {each} (default: {count})")
    parser.add_argument("--first", type=int, default=1, metavar="N", help="number of the first one (default: 1)")
