"""Run chairs with the mind `navigate` on a map: which chairs arrive, touch something or get stuck; what a tick costs.

    python -m tests.agents.navigate_trials --scenes 50 --chairs 5 --csv tests/agents/navigate_trials.csv

Each scene has a number, from which the robot, the start and the goal of each chair are drawn. No two chairs have the
same start or the same goal. A chair has reached its goal once it is within 0.3 m of it. By default the chairs get their
true poses (`truth=true`).

Each row of the CSV is one chair in one scene, with the commit of the code; a + after it means that files have changed
since. The rows of a scene are added when it ends. A scene whose rows are in the file is not run again: the same command
goes on where it was stopped. The last line counts all rows of the file with the same map, options, time and chairs.
"""

from __future__ import annotations

import csv
import math
import random
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from scipy.special import gammaincinv

from intellwheels_agents.mind import Bridge, Mind
from intellwheels_maps import floor
from intellwheels_schemas.messages import Actions, Measures
from tests.agents.arena import Arena
from tests.trial_command import add_runs, trial_parser

ROBOTS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
REACHED = 0.3
STANDS = 0.05
STUCK = 60.0
"""A chair that has stood for longer without being at its goal is stuck, s."""


@dataclass
class Row:
    """What one chair did."""

    commit: str
    ground: str
    options: str
    limit: float
    chairs: int
    scene: int
    chair: str
    robot: str
    start: str
    goal: str
    reached: bool = False
    seconds: float = 0.0
    lasted: float = 0.0
    contacts: int = 0
    longest_stand: float = 0.0
    left_over: float = 0.0
    median_ms: float = 0.0
    worst_ms: float = 0.0

    @property
    def run(self) -> tuple[str, str, float, int, int]:
        """Return what the run of the scene depends on, besides the code."""
        return self.ground, self.options, self.limit, self.chairs, self.scene


def drawn(scene: int, chairs: int, ground: str) -> list[tuple[str, str, str]]:
    """Return the robot, start and goal of each chair of a scene."""
    draw = random.Random(f"navigate {scene}")
    places = floor(ground).grid.position  # type: ignore[union-attr]
    starts = [p.name for p in places if p.kinds is None or "wheelchair" in p.kinds]
    goals = [p.name for p in places if p.kinds is None or "wheelchair" in p.kinds or "goal" in p.kinds]
    first = draw.sample(starts, chairs)
    while True:
        last = draw.sample(goals, chairs)
        if all(a != b for a, b in zip(first, last, strict=True)):
            return [(draw.choice(ROBOTS), a, b) for a, b in zip(first, last, strict=True)]


def trial(
    scene: int,
    chairs: int,
    seconds: float,
    options: dict[str, str],
    ground: str = "ward",
    watch: bool = False,
    commit: str = "",
) -> list[Row]:
    """Return what the chairs of one scene did."""
    arena = Arena(ground, str(scene))
    places = {place.name: place for place in arena.setup.floor.grid.position}  # type: ignore[union-attr]
    chases = []
    for number, (body, start, goal) in enumerate(drawn(scene, chairs, ground)):
        name = f"chair{number + 1}"
        player = arena.join(name, "navigate", body, start, {"to": goal, "truth": "true", **options})
        timed = player.mind = Timed(player.mind)
        row = Row(commit, ground, said(options), seconds, chairs, scene, name, body, start, goal, seconds=seconds)
        chases.append(Chase(row, timed, (places[goal].x, places[goal].y), arena.paths[name][0]))
    for _ in range(round(seconds / arena.setup.period)):
        if all(chase.row.reached for chase in chases):
            break
        arena.step()
        now = arena.state.tick * arena.setup.period
        for chase in chases:
            chase.update(now, arena.paths[chase.row.chair][-1])
            if watch and arena.state.tick % 40 == 0:
                print(f"{now:6.1f} {chase}", flush=True)
    for chase in chases:
        chase.row.lasted = round(arena.state.tick * arena.setup.period, 2)
        chase.row.contacts = sum(event.agent == chase.row.chair for event in arena.contacts())
        spent = sorted(chase.mind.spent)
        chase.row.median_ms = round(1e3 * statistics.median(spent), 2)
        chase.row.worst_ms = round(1e3 * spent[int(0.99 * len(spent))], 2)
    return [chase.row for chase in chases]


def said(options: dict[str, str]) -> str:
    """Return options as one text, in the order of their names."""
    return " ".join(f"{name}={value}" for name, value in sorted(options.items()))


def commit_here() -> str:
    """Return the commit of the code, with a + if files that a run depends on have changed since."""
    folder = Path(__file__).parent
    try:
        commit, changes = (
            subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True, timeout=60, check=True).stdout
            for words in (["rev-parse", "--short=12", "HEAD"], ["status", "--porcelain", "--", ":/", ":!:*.csv"])
        )
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return commit.strip() + ("+" if changes.strip() else "")


def read(file: Path) -> list[Row]:
    """Return the rows of a file that this command wrote; none if there is no such file.

    Raises:
        ValueError: It has other columns.
    """
    if not file.exists():
        return []
    with file.open(newline="") as text:
        reader = csv.DictReader(text)
        wanted = [field.name for field in fields(Row)]
        if reader.fieldnames is not None and list(reader.fieldnames) != wanted:
            raise ValueError(f"{file}: expected the columns {', '.join(wanted)}, got {', '.join(reader.fieldnames)}")
        kinds: dict[str, Callable[[str], Any]] = {"str": str, "int": int, "float": float, "bool": "True".__eq__}
        return [Row(**{one.name: kinds[str(one.type)](line[one.name]) for one in fields(Row)}) for line in reader]


def add(file: Path, rows: Sequence[Row]) -> None:
    """Add rows to a file, below the names of the columns."""
    begins = not file.exists() or file.stat().st_size == 0
    with file.open("a", newline="") as text:
        writer = csv.DictWriter(text, [field.name for field in fields(Row)], lineterminator="\n")
        if begins:
            writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def highest_rate(contacts: int, hours: float) -> float:
    """Return the upper bound at 95 % of the rate of contacts per hour, if they are a Poisson process.

    Source: F. Garwood, Fiducial limits for the Poisson distribution, Biometrika 28 (1936) 437.
    """
    return float(gammaincinv(contacts + 1, 0.95)) / hours


def summary(rows: Sequence[Row]) -> str:
    """Return a line about rows of one condition."""
    reached, contacts = sum(row.reached for row in rows), sum(row.contacts for row in rows)
    hours = sum(row.lasted for row in rows) / 3600.0
    return (
        f"{len({row.scene for row in rows})} scenes: reached {reached} of {len(rows)} "
        f"({100.0 * reached / len(rows):.0f} %), own contacts {contacts} in {hours:.2f} chair-hours "
        f"(at 95 % fewer than {highest_rate(contacts, hours):.2f} an hour), "
        f"stood over {STUCK:.0f} s {sum(row.longest_stand > STUCK for row in rows)}, "
        f"median {statistics.median(row.median_ms for row in rows):.2f} ms, "
        f"highest 99 % of a chair {max(row.worst_ms for row in rows):.2f} ms"
    )


class Timed:
    """A mind whose time is measured."""

    def __init__(self, mind: Mind | Bridge) -> None:
        self._mind = mind
        self.spent: list[float] = []
        self.mode: str | None = None

    def decide(self, measured: Measures) -> Actions:
        began = time.process_time()
        answer = self._mind.decide(measured)
        self.spent.append(time.process_time() - began)
        assert isinstance(answer, Actions)
        self.mode = answer.mode
        return answer


@dataclass
class Chase:
    """A chair on its way to its goal."""

    row: Row
    mind: Timed
    goal: tuple[float, float]
    pose: tuple[float, float, float]
    since: float = 0.0
    stood_at: tuple[float, float, float] | None = None

    def update(self, now: float, pose: tuple[float, float, float]) -> None:
        self.pose, row = pose, self.row
        off = math.dist(pose[:2], self.goal)
        if not row.reached and off <= REACHED:
            row.reached, row.seconds = True, round(now, 2)
        there = self.stood_at or pose
        turned = abs(math.remainder(pose[2] - there[2], math.tau))
        if row.reached or self.stood_at is None or math.dist(pose[:2], there[:2]) > STANDS or turned > 0.1:
            self.since, self.stood_at = now, pose
        row.longest_stand = round(max(row.longest_stand, now - self.since), 2)
        row.left_over = round(off, 2)

    def __str__(self) -> str:
        x, y, heading = self.pose
        return (
            f"{self.row.chair} {x:.2f} {y:.2f} {math.degrees(heading):.0f} {self.mind.mode} left {self.row.left_over}"
        )


def main(words: Sequence[str] | None = None) -> None:
    """Run the trials."""
    parser = trial_parser("tests.agents.navigate_trials", __doc__)
    add_runs(parser, "--scenes", 50, "scenes")
    parser.add_argument("--chairs", type=int, default=1, metavar="N", help="chairs in each scene (default: 1)")
    parser.add_argument(
        "--seconds", type=float, default=180.0, metavar="S", help="longest simulated time of a scene (default: 180)"
    )
    parser.add_argument("--map", default="ward", metavar="MAP", help="the map (default: ward)")
    parser.add_argument(
        "--option", action="append", default=[], metavar="NAME=VALUE",
        help="an option of the mind or, if NAME begins with a capital letter, a field of the robot; may be repeated",
    )  # fmt: skip
    parser.add_argument("--watch", action="store_true", help="also print the pose of each chair every 40 ticks")
    given = parser.parse_args(words)
    options = dict(text.split("=", 1) for text in given.option)
    try:
        kept = read(given.csv) if given.csv else []
    except ValueError as error:
        parser.error(f"argument --csv: {error}")
    commit, same = commit_here(), (given.map, said(options), given.seconds, given.chairs)
    kept = [row for row in kept if row.run[:-1] == same]
    known = {row.scene for row in kept}
    for scene in range(given.first, given.first + given.scenes):
        if scene in known:
            continue
        began = time.process_time()
        found = trial(scene, given.chairs, given.seconds, options, given.map, given.watch, commit)
        kept += found
        if given.csv:
            add(given.csv, found)
        for row in found:
            if not row.reached or row.contacts or given.scenes < 4 or row.longest_stand > 20:
                print(row, flush=True)
        print(f"scene {scene}: {time.process_time() - began:.0f} s", file=sys.stderr, flush=True)
    if kept:
        print(summary(kept))


if __name__ == "__main__":
    main()
