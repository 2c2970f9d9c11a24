from __future__ import annotations

import math
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Measures, Position, ProximityReading, Sensors, Status
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import wedges
from intellwheels_viewer.drawings.wedges import STATES, Cones, Mounts, State, Wedges
from tests.viewer.drawings.cast import RUN, body, entity, node

CHAIR = body("rear-wheel")


def measures(*readings: ProximityReading) -> Measures:
    return Measures(run=RUN, tick=0, time=0.0, sensors=Sensors(proximity=readings))


def reading(value: float | None = None, status: Status = "ok", name: str = "front") -> ProximityReading:
    return ProximityReading(id=name, value=value, status=status)


@pytest.mark.parametrize(
    ("value", "status", "state"),
    [
        (0.49, "ok", "near"),
        (0.5, "ok", "middle"),
        (1.49, "ok", "middle"),
        (1.5, "ok", "far"),
        (None, "near", "near"),
        (None, "none", "nothing"),
        (None, "fault", "failed"),
    ],
)
def test_a_reading_is_in_one_of_five_states(value: float | None, status: Status, state: State) -> None:
    made = wedges.cones({"a": CHAIR}, [entity("a")], {"a": measures(reading(value, status))}, {"a"})
    assert [STATES[each] for each in made.state] == [state]


def test_a_wedge_stands_where_the_sensor_is_and_reaches_as_far_as_the_reading() -> None:
    made = wedges.cones({"a": CHAIR}, [entity("a", 1.0, 2.0, math.pi / 2)], {"a": measures(reading(1.2))}, {"a"})
    assert (*made.x, *made.y) == pytest.approx((1.0, 2.8503))
    assert made.direction == pytest.approx(math.pi / 2)
    assert made.cone == pytest.approx(math.radians(30.0))
    assert made.reach == 1.2


def test_nothing_seen_and_failed_reach_as_far_as_the_sensor_could() -> None:
    for status in ("none", "fault"):
        made = wedges.cones({"a": CHAIR}, [entity("a")], {"a": measures(reading(None, status))}, {"a"})
        assert made.reach == 4.0


def test_what_is_too_near_to_measure_reaches_to_the_least_range() -> None:
    made = wedges.cones({"a": CHAIR}, [entity("a")], {"a": measures(reading(None, "near"))}, {"a"})
    assert made.reach == 0.05


def test_a_sensor_on_the_frame_of_a_door_stays_when_the_leaf_swings() -> None:
    door = body("door", position=Position(x=9.0, y=3.51, heading=-math.pi / 2))
    snapshot = {"door": measures(reading(1.0, name="in-left"))}
    shut, open_ = (
        wedges.cones({"door": door}, [entity("door", 9.0, 3.51, heading)], snapshot, {"door"})
        for heading in (-1.57, 0.0)
    )
    assert all(np.array_equal(getattr(shut, field), getattr(open_, field)) for field in Cones.__slots__)
    assert (*shut.x, *shut.y) == pytest.approx((9.05, 4.3))
    assert shut.direction == pytest.approx(0.0)


def test_a_sensor_on_the_frame_of_a_door_is_not_drawn_while_its_place_is_unknown() -> None:
    door = body("door")
    assert door.robot.position is None
    snapshot = {"door": measures(reading(1.0, name="in-left"))}
    assert len(wedges.cones({"door": door}, [entity("door", 9.0, 3.51)], snapshot, {"door"}).x) == 0


def test_agents_that_were_not_asked_for_and_sensors_without_readings_have_none() -> None:
    snapshot = {"a": measures(reading(1.0)), "b": measures(reading(1.0))}
    cast = {"a": CHAIR, "b": CHAIR}
    assert len(wedges.cones(cast, [entity("a"), entity("b")], snapshot, {"b"}).x) == 1
    assert len(wedges.cones(cast, [entity("a")], {"a": Measures(run=RUN, tick=0, time=0.0)}, {"a"}).x) == 0


def test_readings_belong_to_the_sensor_of_their_name_in_whatever_order_they_come() -> None:
    names = [sensor.id for sensor in CHAIR.robot.proximity]
    readings = [reading(1.0 + index / 10, name=name) for index, name in enumerate(names)]
    states = {"a": CHAIR}, [entity("a", 1.0, 2.0, 0.3)]
    forth, back = (wedges.cones(*states, {"a": measures(*each)}, {"a"}) for each in (readings, readings[::-1]))
    assert forth.reach.tolist() == [each.value for each in readings]
    assert all(np.array_equal(getattr(forth, field), getattr(back, field)) for field in Cones.__slots__)
    strange = wedges.cones(*states, {"a": measures(reading(1.0, name="of another document"))}, {"a"})
    assert len(strange.x) == 0


def test_a_body_that_comes_again_with_another_document_has_its_sensors_where_that_says() -> None:
    mounts, first = Mounts(), CHAIR.robot.proximity[0]
    moved = msgspec.structs.replace(CHAIR.robot, proximity=(msgspec.structs.replace(first, x=first.x + 1.0),))
    snapshot, there = {"a": measures(reading(1.0, name=first.id))}, [entity("a")]
    one = wedges.cones({"a": CHAIR}, there, snapshot, {"a"}, None, mounts)
    other = wedges.cones({"a": msgspec.structs.replace(CHAIR, robot=moved)}, there, snapshot, {"a"}, None, mounts)
    assert other.x == pytest.approx(one.x + 1.0)


def wedge(state: State, reach: float = 2.0, *, edged: bool = True) -> Cones:
    column = np.zeros(1)
    number = np.array([STATES.index(state)], np.int8)
    return Cones(column, column, column, column + math.radians(30.0), column + reach, number, np.array([edged]))


@pytest.mark.parametrize("reach", [0.3, 4.0])
def test_the_arc_is_three_centimetres_thick_at_any_distance_and_ends_at_the_reading(reach: float) -> None:
    bars = wedges.bars(wedge("far", reach))
    assert len(bars.positions) == 3
    assert bars.sizes[:, 1] == pytest.approx(np.full(3, 0.03))
    assert np.hypot(*bars.positions[:, :2].T) + 0.015 == pytest.approx(np.full(3, reach), abs=1e-5)
    assert float(bars.sizes[:, 0].sum()) == pytest.approx(reach * math.radians(30.0), rel=0.01)


def test_nothing_seen_has_no_arc_and_a_failure_has_dashes_within_its_cone() -> None:
    assert len(wedges.bars(wedge("nothing")).positions) == 0
    assert len(wedges.bars(wedge("far", edged=False)).positions) == 0
    dashes = wedges.bars(wedge("failed", edged=False))
    assert len(dashes.positions) > 12
    angles = np.arctan2(dashes.positions[:, 1], dashes.positions[:, 0])
    assert float(abs(angles).max()) <= math.radians(15.0) + 1e-5


def test_a_fan_is_one_metre_long_and_as_wide_as_its_cone() -> None:
    fan = wedges.fan(math.radians(60.0)).vertices
    assert float(np.hypot(*fan[:, :2].T).max()) == pytest.approx(1.0)
    assert float(fan[:, 1].max()) == pytest.approx(0.5)


def test_fans_are_a_node_for_each_cone_and_failed_ones_have_none(scene: viser.SceneApi) -> None:
    shown, nurse = Wedges(scene), body("person")
    readings = (reading(0.3), reading(None, "none", "left"), reading(None, "fault", "right"))
    shown.show({"a": CHAIR, "n": nurse}, [entity("a"), entity("n", 3.0)], {"a": measures(*readings)}, {"a", "n"})
    fans = node(scene, "/wedges/fan-30")
    assert fans.batched_positions.shape == (2, 3)
    assert fans.batched_scales[:, 0] == pytest.approx([0.3, 4.0])
    assert fans.batched_colors.tolist() == palette.light_bytes([palette.NEAR, palette.NOTHING]).tolist()
    assert fans.batched_opacities[1] < fans.batched_opacities[0]
    assert node(scene, "/wedges/fan-60") is None
    shown.show({"a": CHAIR, "n": nurse}, [entity("n")], {"n": measures(reading(1.0))}, {"n"})
    assert not fans.visible
    assert node(scene, "/wedges/fan-60").visible


class Rows(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.states: list[str] = []
        self.open = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open += tag != "path"
        self.states += [value for key, value in attrs if key == "data-state" and value]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Count none."""

    def handle_endtag(self, tag: str) -> None:
        self.open -= 1


def test_the_legend_shows_all_five_states() -> None:
    rows = Rows()
    rows.feed(wedges.legend())
    assert rows.states == ["near", "middle", "far", "nothing", "failed"]
    assert rows.open == 0
