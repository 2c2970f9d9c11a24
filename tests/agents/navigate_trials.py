"""Chairs with the mind `navigate` on the ward, many scenes: who arrives, who touches, who stands, and what a tick costs.

    python -m tests.agents.navigate_trials --scenes 50 --chairs 5 --csv FILE

A scene draws its chairs, their starts and their goals from its number: different places of the map, different goals, a
robot each. All chairs use `navigate`. A chair has reached its goal once it is within 0.3 m of it. A row is a chair.
"""

from __future__ import annotations

import argparse
import csv
import math
import random
import statistics
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from intellwheels_maps import floor
from intellwheels_server.world import measures
from tests.agents.arena import Arena

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
    reached: bool
    seconds: float
    contacts: int
    longest_stand: float
    left_over: float
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
    scene: int, chairs: int, seconds: float, ground: str = "ward", options: dict[str, str] | None = None,
    times: list[float] | None = None, watch: bool = False,
) -> list[Row]:
    """Return what the chairs of one scene did."""
    arena = Arena(ground, str(scene))
    places = {p.name: p for p in arena.setup.floor.grid.position}  # type: ignore[union-attr]
    rows, goals, since, stood = [], {}, {}, {}
    for number, (body, start, goal) in enumerate(drawn(scene, chairs, ground)):
        name = f"chair{number + 1}"
        arena.join(name, "navigate", body, start, {"to": goal, "truth": "true", **(options or {})})
        rows.append(Row(scene, name, body, start, goal, False, seconds, 0, 0.0, 0.0))
        goals[name] = (places[goal].x, places[goal].y)
        since[name], stood[name] = (0.0, arena.paths[name][0]), 0.0
    spent: dict[str, list[float]] = {row.chair: [] for row in rows}
    for row in rows:
        player = arena.players[row.chair]
        player.mind = Timed(player.mind, spent[row.chair])  # type: ignore[arg-type]
    for _ in range(round(seconds / arena.setup.period)):
        if all(row.reached for row in rows):
            break
        arena.step()
        now = arena.state.tick * arena.setup.period
        for row in rows:
            pose = arena.paths[row.chair][-1]
            off = math.dist(pose[:2], goals[row.chair])
            if not row.reached and off <= REACHED:
                row.reached, row.seconds = True, now
            at, there = since[row.chair]
            if row.reached or math.dist(pose[:2], there[:2]) > STANDS or abs(math.remainder(pose[2] - there[2], math.tau)) > 0.1:
                since[row.chair] = (now, pose)
            row.longest_stand = max(row.longest_stand, now - since[row.chair][0])
            row.left_over = round(off, 2)
            if watch and arena.state.tick % 40 == 0:
                last = measures(arena.state, row.chair)
                print(f"{now:6.1f} {row.chair} {pose[0]:.2f} {pose[1]:.2f} {math.degrees(pose[2]):.0f} off {off:.2f} v {arena.speed(row.chair):.2f} {player_mode(arena, row.chair)} {last.collision}")
    for row in rows:
        row.contacts = sum(event.agent == row.chair for event in arena.contacts())
        ordered = sorted(spent[row.chair])
        row.median_ms = round(1e3 * statistics.median(ordered), 2)
        row.worst_ms = round(1e3 * ordered[int(0.99 * len(ordered))], 2)
        if times is not None:
            times += ordered
    return rows


class Timed:
    """A mind whose time is measured."""

    def __init__(self, mind: object, spent: list[float]) -> None:
        self.mind, self._spent = mind, spent
        self.mode = ""

    def decide(self, measured: object) -> object:
        began = time.process_time()
        answer = self.mind.decide(measured)  # type: ignore[attr-defined]
        self._spent.append(time.process_time() - began)
        self.mode = answer.mode
        return answer


def player_mode(arena: Arena, name: str) -> str:
    return str(arena.players[name].mind.mode)  # type: ignore[union-attr]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--chairs", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=180.0)
    parser.add_argument("--map", default="ward")
    parser.add_argument("--option", action="append", default=[])
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--watch", action="store_true")
    given = parser.parse_args()
    options = dict(text.split("=", 1) for text in given.option)
    rows: list[Row] = []
    times: list[float] = []
    for scene in range(given.first, given.first + given.scenes):
        began = time.process_time()
        found = trial(scene, given.chairs, given.seconds, given.map, options, times, given.watch)
        rows += found
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
