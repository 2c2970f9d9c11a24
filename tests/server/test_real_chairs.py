"""What a real chair's poses may do: jump, fall silent, come late or out of order, be no number, be another's."""

from __future__ import annotations

import json
import math

import pytest

from intellwheels_schemas.messages import Pose
from tests.server.stage import RUN, Stage, real

TICK = 0.0501


class Reported:
    """A real chair in real time, and what its bridge says."""

    def __init__(self) -> None:
        self.stage = Stage(pace="realtime", strict=False)
        self.session = self.stage.join("chair1", real()).session
        self.seq = 0

    def say(self, x: float, y: float = 2.6, **more: object) -> None:
        self.seq += 1
        given = {"session": self.session, "heading": 0.0, "seq": self.seq, **more}
        self.stage.put("chair1", Pose(x=x, y=y, **given), "pose")  # type: ignore[arg-type]

    def on(self, ticks: int = 1) -> None:
        self.stage.work(TICK * ticks)

    @property
    def x(self) -> float:
        return float(self.stage.of("state")[-1].entity[0].x)

    @property
    def codes(self) -> list[str]:
        return [error.code for error in self.stage.errors("chair1")]


@pytest.fixture
def chair() -> Reported:
    made = Reported()
    for _ in range(4):
        made.say(2.0)
        made.on()
    return made


def test_jumping_pose_is_accepted_and_its_speed_is_limited(chair: Reported) -> None:
    chair.say(7.0)
    chair.on()
    assert chair.x == 7.0
    assert chair.stage.of("state")[-1].entity[0].speed <= 100.0
    # Into a wall: both are flagged, nothing else moves.
    chair.say(0.0)
    chair.on()
    assert chair.x == 0.0
    assert chair.stage.of("state")[-1].entity[0].collision
    assert "contact" in chair.stage.events()


def test_silent_chair_is_stale_and_stops_until_it_reports_again(chair: Reported) -> None:
    chair.stage.act("chair1", 0.5, 0.5)
    for _ in range(10):
        chair.stage.act("chair1", 0.5, 0.5)
        chair.on()
    assert "stale" in chair.stage.events()
    assert chair.x == 2.0
    power = chair.stage.of("power", "chair1")[-1]
    assert (power.left_motor, power.state) == (0.0, "stale")
    chair.say(2.1)
    chair.on()
    assert chair.stage.events()[-1] == "fresh"
    assert chair.x == 2.1


def test_pose_of_the_last_tick_is_accepted_and_an_older_one_is_late(chair: Reported) -> None:
    tick = chair.stage.tick
    chair.say(2.1, tick=tick - 1, run=RUN)
    chair.on()
    assert (chair.x, chair.codes) == (2.1, [])
    chair.say(2.2, tick=tick - 3, run=RUN)
    chair.on()
    assert (chair.x, chair.codes) == (2.1, ["late"])


def test_newest_pose_counts_whatever_the_order(chair: Reported) -> None:
    chair.say(2.3, seq=50)
    chair.say(2.2, seq=49)
    chair.on()
    assert chair.x == 2.3


@pytest.mark.parametrize("text", ["NaN", '"NaN"', "Infinity", "1e999", "null", "20000"])
def test_pose_with_invalid_numbers_gives_an_error(chair: Reported, text: str) -> None:
    data = json.dumps({"Session": chair.session, "Y": 2.6, "Heading": 0.0})[:-1] + f', "X": {text}}}'
    chair.stage.put("chair1", data.encode(), "pose")
    chair.on()
    assert chair.x == 2.0
    assert len(chair.codes) == 1
    assert chair.codes[0] in ("malformed", "value")


@pytest.mark.parametrize("session", [None, "f" * 16])
def test_pose_with_another_session_is_dropped(chair: Reported, session: str | None) -> None:
    named = {} if session is None else {"Session": session}
    chair.stage.put("chair1", json.dumps({**named, "X": 3.0, "Y": 2.6, "Heading": 0.0}).encode(), "pose")
    chair.on()
    assert (chair.x, chair.codes) == (2.0, ["field" if session is None else "session"])


def test_pose_of_another_run_is_late(chair: Reported) -> None:
    chair.say(3.0, run="0" * 16)
    chair.on()
    assert (chair.x, chair.codes) == (2.0, ["late"])


def test_reported_heading_is_wrapped(chair: Reported) -> None:
    chair.say(2.0, heading=1.5 * math.pi)
    chair.on()
    assert chair.stage.of("state")[-1].entity[0].heading == pytest.approx(-math.pi / 2.0, abs=1e-6)


def test_two_real_chairs_may_join_at_one_place_and_separate(chair: Reported) -> None:
    stage = chair.stage
    other = stage.join("chair2", real()).session
    stage.put("chair2", Pose(session=other, x=2.0, y=2.6, heading=0.0, seq=1), "pose")
    chair.say(2.0)
    chair.on()
    first, second = stage.of("state")[-1].entity
    assert (first.x, second.x) == (2.0, 2.0)
    stage.put("chair2", Pose(session=other, x=5.0, y=2.6, heading=0.0, seq=2), "pose")
    for _ in range(8):
        chair.say(2.0)
        chair.on()
    first, second = stage.of("state")[-1].entity
    assert (first.x, second.x) == (2.0, 5.0)
    assert [one.collision or one.contact for one in (first, second)] == [False, False]
    assert stage.events()[:4] == ["joined", "joined", "contact", "parted"]
    assert (first.contacts, second.contacts) == (1, 1)
