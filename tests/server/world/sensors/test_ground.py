"""Ground sensors: which zone is under a point of the body."""

from __future__ import annotations

import math

from intellwheels_schemas.file_records import Restart
from intellwheels_schemas.messages import Corner, Ground, Zone
from intellwheels_server.world import State, measures
from tests.server.worlds import RUN, cart, do, floor_of, run, world


def _zone(name: str, *corners: tuple[float, float]) -> Zone:
    return Zone(name=name, corner=tuple(Corner(x=x, y=y) for x, y in corners))


_FLOOR = floor_of()
_FLOOR = type(_FLOOR)(
    format="iw.v1",
    name="zones",
    zone=(
        _zone("west", (0, 0), (2, 0), (2, 4), (0, 4)),
        _zone("east", (2, 0), (4, 0), (4, 4), (2, 4)),
        _zone("all", (-1, -1), (9, -1), (9, 1), (5, 1), (5, 5), (-1, 5)),
    ),
)


def _under(state: State) -> list[str | None]:
    sensors = measures(state, "a").sensors
    assert sensors is not None
    return [reading.zone for reading in sensors.ground]


def test_zone_under_a_point_is_the_first_that_holds_it() -> None:
    points = ((0.0, 0.0), (1.2, 0.0), (3.5, 0.0), (3.5, -0.8), (20.0, 0.0), (3.5, 1.0))
    ground = tuple(Ground(id=f"g{k}", x=x, y=y) for k, (x, y) in enumerate(points))
    assert _under(world({"a": cart(1.0, 1.5, ground=ground)}, floor=_FLOOR)) == [
        "west", "east", "all", "all", None, "all",
    ]  # fmt: skip


def test_border_of_two_zones_belongs_to_one_of_them() -> None:
    assert _under(world({"a": cart(2.0, 1.0, ground=(Ground(id="g"),))}, floor=_FLOOR)) == ["east"]


def test_point_turns_with_the_body() -> None:
    state = world({"a": cart(1.0, 1.0, math.pi / 2, ground=(Ground(id="g", y=-1.5),))}, floor=_FLOOR)
    assert _under(state) == ["east"]
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    assert _under(state) == ["east"]


def test_floor_without_zones_and_another_floor() -> None:
    state = world({"a": cart(1.0, 1.0, ground=(Ground(id="g"),))})
    assert _under(state) == [None]
    state, outcome, _ = do(state, Restart(run=RUN, seed="1", map=_FLOOR))
    assert outcome.code == "ok"
    assert _under(state) == ["west"]
