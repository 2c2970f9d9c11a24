"""Run chairs with the mind `navigate` on a map: which chairs arrive, touch something or get stuck; what a tick costs.

    python -m tests.agents.navigate_trials --scenes 50 --chairs 5 --csv FILE

Each scene has a number, from which the robot, the start and the goal of each chair are drawn. No two chairs have the
same start or the same goal. A chair has reached its goal once it is within 0.3 m of it. By default the chairs get their
true poses (`truth=true`). Each row of the CSV is one chair in one scene.
"""

from __future__ import annotations

import csv
import math
import random
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from intellwheels_agents.mind import Bridge, Mind
from intellwheels_maps import floor
from intellwheels_schemas.messages import Actions, Measures
from tests.agents.arena import Arena
from tests.trial_command import add_runs, trial_parser

ROBOTS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
REACHED = 0.3
STANDS = 0.05


@dataclass
class Row:
    """What one chair did."""

    scene: int
    chair: str
    robot: str
    start: str
    goal: str
    reached: bool = False
    seconds: float = 0.0
    contacts: int = 0
    longest_stand: float = 0.0
    left_over: float = 0.0
    median_ms: float = 0.0
    worst_ms: float = 0.0


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
    scene: int, chairs: int, seconds: float, options: dict[str, str], ground: str = "ward", watch: bool = False
) -> tuple[list[Row], list[float]]:
    """Return what the chairs of one scene did, and the seconds that each tick of each mind took, ascending."""
    arena = Arena(ground, str(scene))
    places = {place.name: place for place in arena.setup.floor.grid.position}  # type: ignore[union-attr]
    chases = []
    for number, (body, start, goal) in enumerate(drawn(scene, chairs, ground)):
        name = f"chair{number + 1}"
        player = arena.join(name, "navigate", body, start, {"to": goal, "truth": "true", **options})
        timed = player.mind = Timed(player.mind)
        row = Row(scene, name, body, start, goal, seconds=seconds)
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
        chase.row.contacts = sum(event.agent == chase.row.chair for event in arena.contacts())
        spent = sorted(chase.mind.spent)
        chase.row.median_ms = round(1e3 * statistics.median(spent), 2)
        chase.row.worst_ms = round(1e3 * spent[int(0.99 * len(spent))], 2)
    return [chase.row for chase in chases], sorted(spent for chase in chases for spent in chase.mind.spent)


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
    rows: list[Row] = []
    times: list[float] = []
    for scene in range(given.first, given.first + given.scenes):
        began = time.process_time()
        found, spent = trial(scene, given.chairs, given.seconds, options, given.map, given.watch)
        rows += found
        times += spent
        for row in found:
            if not row.reached or row.contacts or given.scenes < 4 or row.longest_stand > 20:
                print(row, flush=True)
        print(f"scene {scene}: {time.process_time() - began:.0f} s", file=sys.stderr, flush=True)
    reached = sum(row.reached for row in rows)
    times.sort()
    print(
        f"reached {reached} of {len(rows)} ({100.0 * reached / len(rows):.0f} %), "
        f"contacts {sum(row.contacts for row in rows)}, stood over 60 s {sum(row.longest_stand > 60 for row in rows)}, "
        f"median {1e3 * statistics.median(times):.2f} ms, 99 % {1e3 * times[int(0.99 * len(times))]:.2f} ms"
    )
    if given.csv:
        with given.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(asdict(rows[0])))
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)


if __name__ == "__main__":
    main()
