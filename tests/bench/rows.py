"""Rows of benchmark results: printed as a table, appended to a CSV file that is kept in git."""

from __future__ import annotations

import csv
import os
import platform
import subprocess
from dataclasses import astuple, dataclass, fields
from pathlib import Path


@dataclass(frozen=True)
class Row:
    """A figure.

    Attributes:
        bench: What was measured.
        case: Under which circumstances.
        figure: Name of the figure.
        value: The figure.
        unit: Its unit.
        goal: What it should be at most or at least, or empty.
    """

    bench: str
    case: str
    figure: str
    value: float
    unit: str
    goal: str = ""


HEAD = ("machine", "commit", "load", *(field.name for field in fields(Row)))


def machine() -> str:
    """Return the processor's name and number of cores; no name of a host."""
    name = platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [line.partition(":")[2].strip() for line in cpuinfo.read_text().splitlines() if "model name" in line]
        name = names[0] if names else name
    return f"{name}, {os.cpu_count()} cores, Python {platform.python_version()}"


def commit() -> str:
    """Return the checkout's commit, with a + where files differ from it."""
    here = Path(__file__).parent

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=here, capture_output=True, text=True, check=False).stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", "server", "schemas", "agents")
    return (git("rev-parse", "--short", "HEAD") or "none") + ("+" if changed else "")


def append(rows: list[Row], file: Path, of: str = "") -> None:
    """Append rows of a commit to the CSV file, by default those of the checkout's; with its head if it is new."""
    new = not file.exists()
    load = f"{os.getloadavg()[0]:.2f}"
    with file.open("a", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        if new:
            writer.writerow(HEAD)
        for row in rows:
            known = [f"{value:.4g}" if isinstance(value, float) else value for value in astuple(row)]
            writer.writerow([machine(), of or commit(), load, *known])


def show(rows: list[Row]) -> None:
    """Print rows as a table."""
    width = [max(len(getattr(row, name)) for row in rows) for name in ("bench", "case", "figure")]
    for row in rows:
        goal = f"   goal {row.goal}" if row.goal else ""
        head = f"{row.bench:{width[0]}}  {row.case:{width[1]}}  {row.figure:{width[2]}}"
        print(f"{head}  {row.value:10.4g} {row.unit}{goal}")
