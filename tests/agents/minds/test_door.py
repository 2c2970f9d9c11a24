"""A door opens for somebody, waits, and closes again."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.minds.door import Mind
from intellwheels_maps import robot
from intellwheels_schemas.messages import Heard
from tests.agents.kinematics import PERIOD, Body, Segment, box, context

LEAF = robot("door")
JAMBS = box(-0.05, -3.0, 0.05, -0.06) + box(-0.05, 1.04, 0.05, 3.0) + box(-9.0, -3.0, 9.0, 3.0)


class Doorway:
    """A door hinged at the origin, closed along y, with obstacles in front of it."""

    def __init__(self, body: Body, **options: str) -> None:
        self.body = body
        self.mind = Mind(context(LEAF, body.position, **options))
        self.said: list[str] = []

    def run(
        self,
        seconds: float,
        somebody: list[Segment] | None = None,
        heard: tuple[Heard, ...] = (),
        contact: bool = False,
    ) -> float:
        """Let it be for so long and return by how many degrees it is open then."""
        for _ in range(round(seconds / PERIOD)):
            actions = self.mind.decide(self.body.measures(JAMBS + (somebody or []), heard, contact))
            if actions.say:
                self.said.append(actions.say)
            self.body.step(actions)
            heard, contact = (), False
        return self.opened

    @property
    def opened(self) -> float:
        return math.degrees(math.remainder(self.body.heading - self.body.start[2], 2.0 * math.pi))


def door(compass_noise: float = 0.0, range_noise: float = 0.0, motor_noise: float = 0.0, **options: str) -> Doorway:
    # The leaf lies behind its centre: at -90 degrees it reaches from the hinge to y = 0.99.
    body = Body(
        LEAF,
        heading=-math.pi / 2.0,
        compass_noise=compass_noise,
        range_noise=range_noise,
        motor_noise=motor_noise,
    )
    return Doorway(body, **options)


CHAIR = box(1.5, 0.3, 2.6, 0.9)


def test_door_stays_closed_while_nobody_comes() -> None:
    doorway = door()
    assert doorway.run(20.0) == pytest.approx(0.0, abs=1e-9)
    assert doorway.said == ["door closed"]


def test_door_opens_for_somebody_holds_five_seconds_and_closes() -> None:
    doorway = door()
    doorway.run(1.0)
    doorway.run(0.5, CHAIR)
    # 90 degrees in 4 s; the last degree is slower.
    assert doorway.run(4.5) == pytest.approx(90.0, abs=1.0)
    assert doorway.run(0.4) == pytest.approx(90.0, abs=1.0)
    assert 0.5 < doorway.run(1.5) < 89.0
    assert doorway.run(4.5) == pytest.approx(0.0, abs=1.0)
    assert doorway.said == ["door closed", "door opening", "door open", "door closing", "door closed"]


@pytest.mark.parametrize(("swing", "sign"), [("left", 1.0), ("right", -1.0)])
def test_swing_side_is_an_option(swing: str, sign: float) -> None:
    doorway = door(swing=swing)
    doorway.run(1.0)
    assert doorway.run(5.0, CHAIR) == pytest.approx(sign * 90.0, abs=1.0)


def test_door_never_closes_while_somebody_stands_there() -> None:
    doorway = door()
    doorway.run(1.0)
    doorway.run(5.0, CHAIR)
    assert doorway.run(30.0, CHAIR) == pytest.approx(90.0, abs=1.0)


def test_door_never_closes_while_somebody_stands_in_the_opening() -> None:
    doorway = door()
    doorway.run(1.0)
    doorway.run(5.0, CHAIR)
    # Between the cones that look outward, in the plane of the leaf.
    assert doorway.run(30.0, box(-0.15, 0.3, 0.15, 0.7)) == pytest.approx(90.0, abs=1.0)
    assert doorway.run(11.0) == pytest.approx(0.0, abs=1.0)


def test_closing_door_opens_again_when_somebody_comes() -> None:
    doorway = door()
    doorway.run(1.0)
    doorway.run(5.0, CHAIR)
    assert 10.0 < doorway.run(7.0) < 80.0
    assert doorway.run(5.0, CHAIR) == pytest.approx(90.0, abs=1.0)


def test_closing_door_opens_again_when_it_touches_somebody() -> None:
    doorway = door()
    doorway.run(1.0)
    doorway.run(5.0, CHAIR)
    doorway.run(7.0)
    assert doorway.said[-1] == "door closing"
    doorway.run(PERIOD, contact=True)
    assert doorway.said[-1] == "door opening"


@pytest.mark.parametrize(
    ("text", "distance", "opens"),
    [("open", 2.0, True), (" Open ", 2.0, True), ("open", 3.5, False), ("door open", 1.0, False)],
)
def test_door_obeys_open_from_nearby_only(text: str, distance: float, opens: bool) -> None:
    doorway = door()
    doorway.run(1.0)
    doorway.run(3.0, heard=(Heard(sender="chair1", tick=19, distance=distance, text=text),))
    assert (doorway.opened > 30.0) is opens


def test_somebody_there_from_the_start_is_background() -> None:
    doorway = door()
    assert doorway.run(10.0, CHAIR) == 0.0


def test_noise_neither_opens_the_door_nor_makes_it_rattle() -> None:
    noise = {"compass_noise": math.radians(2.0), "range_noise": 0.02, "motor_noise": 0.015}
    doorway = door(**noise)  # type: ignore[arg-type]
    assert doorway.run(60.0) == 0.0
    # With noise of 2 cm only what is clearly nearer counts, and still it counts.
    assert doorway.run(6.0, CHAIR) == pytest.approx(90.0, abs=1.5)
    assert doorway.run(15.0) == pytest.approx(0.0, abs=1.5)


def test_leaf_slides_forward_and_back() -> None:
    leaf = msgspec.structs.replace(robot("door"), anchored=False)
    body = Body(leaf, heading=-math.pi / 2.0)
    doorway = Doorway(body, slide="0.9")
    doorway.run(1.0)
    doorway.run(5.0, CHAIR)
    assert (body.x, body.y) == pytest.approx((0.0, -0.9), abs=0.02)
    doorway.run(11.0)
    assert (body.x, body.y) == pytest.approx((0.0, 0.0), abs=0.02)
    assert doorway.said == ["door closed", "door opening", "door open", "door closing", "door closed"]
