"""Run minds with late sensors and commands, other periods, chairs and motors: who arrives, and who touches what.

    python -m tests.agents.late_trials --seeds 8 --csv tests/agents/late_trials.csv

A chair drives through the map `corridor15m`: `seek` and `navigate` to its end, `aided` with a user who holds the stick
forward most of the time and turns at random, without regard to obstacles. First one condition is changed at a time,
then several together, drawn at random. Each row of the CSV is one run. `navigate` gets its true pose at once; the other
sensors of all minds come late. Exit code 1: a chair touched something that its sensors had reported, or one with `seek`
or `navigate` did not arrive.
"""

from __future__ import annotations

import csv
import math
import random
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace

import msgspec

from intellwheels_schemas.messages import Actions, Event, Robot, Sensors, UserInput
from intellwheels_server.world import measures
from tests.agents.arena import Arena
from tests.agents.navigate_trials import Timed
from tests.trial_command import trial_parser

MINDS = ("seek", "navigate", "aided")
CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
SENSORS_LATE = (0, 1, 2, 4)
COMMANDS_LATE = (0, 1, 2, 3, 4)
PERIODS_MS = (10, 20, 50, 100, 200)
LIMITS = (0.3, 0.5, 1.0, 2.0)
CURVES = (0.0, 0.5, 0.8, 0.95)
TOGETHER = 12
"""Conditions of several changes, drawn."""
GOAL = (15.0, 0.0)
NEAR = 0.3
SAME = 0.05
"""A reading that differs by so much from the distance of a place shows something else, m."""
LATE = ("proximity", "lidar", "encoders", "odometry")


@dataclass(frozen=True)
class Condition:
    """How late a chair senses and obeys (ticks), the period (ms), and its motors; None as its document says."""

    chair: str = "corridor-chair"
    sensors_late: int = 0
    commands_late: int = 0
    period_ms: int = 50
    limit: float | None = None
    curve: float | None = None


@dataclass(frozen=True)
class Row:
    """What a chair did in one run."""

    mind: str
    chair: str
    sensors_late: int
    commands_late: int
    period_ms: int
    limit: float | None
    curve: float | None
    seed: int
    reached: bool
    seconds: float
    contacts: int
    reported: int
    closing: float
    slow: bool
    worst_ms: float


class LateArena(Arena):
    """An arena whose sensors and commands are late."""

    def __init__(self, ground: str, seed: str, condition: Condition) -> None:
        super().__init__(ground, seed, condition.period_ms / 1000.0)
        self._condition = condition
        self._line: deque[Actions] = deque()
        self._readings: deque[tuple[int, Sensors | None]] = deque(maxlen=400)
        self.modes: set[str | None] = set()
        self.robot = Robot()

    def adapted(self, document: Robot) -> Robot:
        late = self._condition.sensors_late
        changed = {
            field: tuple(msgspec.structs.replace(one, latency=late) for one in getattr(document, field))
            for field in LATE
        }
        self.robot = msgspec.structs.replace(document, **changed)
        return self.robot

    def sent(self, name: str, answer: Actions) -> Actions:
        self._readings.append((self.state.tick, measures(self.state, name).sensors))
        self.modes.add(answer.mode)
        self._line.append(Actions(left_motor=answer.left_motor, right_motor=answer.right_motor))
        if len(self._line) <= self._condition.commands_late:
            return Actions(left_motor=0.0, right_motor=0.0)
        return self._line.popleft()

    def was_reported(self, event: Event) -> bool:
        """Return whether a reading had shown the place of a contact: near it, at that distance, in the beam."""
        assert event.x is not None
        assert event.y is not None
        cones = {sensor.id: sensor for sensor in self.robot.proximity}
        lidars = {sensor.id: sensor for sensor in self.robot.lidar}
        for now, sensors in self._readings:
            for reading in sensors.proximity if sensors else ():
                tick, cone = now if reading.tick is None else reading.tick, cones[reading.id]
                off, angle = self._seen_from(tick, cone.x, cone.y, cone.direction_deg, event.x, event.y)
                inside = abs(angle) <= math.radians(cone.cone_deg) / 2.0
                if inside and reading.value is not None and abs(off - reading.value) < SAME:
                    return True
            for scan in sensors.lidar if sensors else ():
                tick, lidar = now if scan.tick is None else scan.tick, lidars[scan.id]
                off, angle = self._seen_from(tick, lidar.x, lidar.y, lidar.direction_deg, event.x, event.y)
                ray = round((math.degrees(angle) - scan.start_deg) / scan.step_deg)
                metres = scan.ranges[ray] if 0 <= ray < len(scan.ranges) else None
                if metres is not None and abs(off - metres) < SAME:
                    return True
        return False

    def _seen_from(self, tick: int, x: float, y: float, degrees: float, px: float, py: float) -> tuple[float, float]:
        """Return the distance (m) and the angle (rad) of a point for a sensor of the chair at a tick."""
        bx, by, heading = self.paths["chair"][tick]
        s, c = math.sin(heading), math.cos(heading)
        dx, dy = px - bx - c * x + s * y, py - by - s * x - c * y
        return math.hypot(dx, dy), math.remainder(math.atan2(dy, dx) - heading - math.radians(degrees), math.tau)


def conditions() -> Iterator[Condition]:
    """Return the conditions: the usual one, each change alone, then several together."""
    usual = Condition()
    yield usual
    yield from (replace(usual, chair=chair) for chair in CHAIRS)
    yield from (replace(usual, sensors_late=late) for late in SENSORS_LATE[1:])
    yield from (replace(usual, commands_late=late) for late in COMMANDS_LATE[1:])
    yield from (replace(usual, period_ms=period) for period in PERIODS_MS if period != usual.period_ms)
    yield from (replace(usual, limit=limit) for limit in LIMITS)
    yield from (replace(usual, curve=curve) for curve in CURVES)
    draw = random.Random("late")
    for _ in range(TOGETHER):
        yield Condition(
            draw.choice(CHAIRS), draw.choice(SENSORS_LATE), draw.choice(COMMANDS_LATE), draw.choice(PERIODS_MS),
            draw.choice((None, *LIMITS)), draw.choice((None, *CURVES)),
        )  # fmt: skip


def trial(mind: str, condition: Condition, seed: int, seconds: float = 90.0) -> Row:
    """Return what a chair did, within so many seconds."""
    arena = LateArena("corridor15m", str(seed), condition)
    options = {"MotorNoise": "0.015"}
    if condition.limit is not None:
        options["AccelerationLimit"] = str(condition.limit)
    if condition.curve is not None:
        options["AccelerationCurve"] = str(condition.curve)
    options |= {"navigate": {"to": "goal", "truth": "true"}, "seek": {"to": "goal"}, "aided": {}}[mind]
    player = arena.join("chair", mind, condition.chair, "start", options)
    timed = player.mind = Timed(player.mind)
    user = random.Random(seed)
    wished_until = reached_at = 0.0
    reached = False
    while not reached and arena.state.tick * arena.setup.period < seconds:
        now = arena.state.tick * arena.setup.period
        if mind == "aided" and now >= wished_until:
            turn = user.choice([0.0, 0.0, 0.3, -0.3, 1.0, -1.0])
            arena.users["chair"] = UserInput(forward=user.choice([1.0, 1.0, 1.0, 0.6, -0.7]), turn=turn)
            wished_until = now + user.uniform(0.5, 4.0)
        arena.step()
        reached = mind != "aided" and math.dist(arena.paths["chair"][-1][:2], GOAL) < NEAR
        reached_at = arena.state.tick * arena.setup.period
    contacts = arena.contacts()
    reported = [event for event in contacts if arena.was_reported(event)]
    spent = sorted(timed.spent)
    return Row(
        mind, condition.chair, condition.sensors_late, condition.commands_late, condition.period_ms, condition.limit,
        condition.curve, seed, reached, round(reached_at, 2), len(contacts), len(reported),
        round(max((event.speed or 0.0 for event in reported), default=0.0), 3), "slow" in arena.modes,
        round(1e3 * spent[int(0.99 * len(spent))], 1),
    )  # fmt: skip


def main(words: Sequence[str] | None = None) -> None:
    """Run the trials."""
    parser = trial_parser("tests.agents.late_trials", __doc__)
    parser.add_argument(
        "--minds", nargs="+", choices=MINDS, default=list(MINDS), metavar="MIND",
        help=f"minds (default: {', '.join(MINDS)})",
    )  # fmt: skip
    parser.add_argument(
        "--seeds",
        type=int,
        default=8,
        metavar="N",
        help="runs of each mind and condition, with the seeds 1 to N (default: 8)",
    )
    parser.add_argument(
        "--only", type=int, nargs="+", metavar="N",
        help=f"numbers of conditions, from 0 to {sum(1 for _ in conditions()) - 1} (default: all)",
    )  # fmt: skip
    given = parser.parse_args(words)
    rows: list[Row] = []
    for mind in given.minds:
        for number, condition in enumerate(conditions()):
            if given.only and number not in given.only:
                continue
            found = [
                trial(mind, condition, seed, 20.0 if mind == "aided" else 90.0) for seed in range(1, given.seeds + 1)
            ]
            rows += found
            reached, touched = sum(row.reached for row in found), sum(row.reported for row in found)
            text = f"{mind} {number} {condition}: reached {reached} of {len(found)}, reported and touched {touched}"
            contacts, worst = sum(row.contacts for row in found), max(row.worst_ms for row in found)
            print(f"{text}, all contacts {contacts}, 99 % {worst} ms", flush=True)
            if given.csv:
                with given.csv.open("w", newline="") as file:
                    writer = csv.DictWriter(file, list(asdict(rows[0])), lineterminator="\n")
                    writer.writeheader()
                    writer.writerows(asdict(row) for row in rows)
    sys.exit(any(row.reported or not (row.reached or row.mind == "aided") for row in rows))


if __name__ == "__main__":
    main()
