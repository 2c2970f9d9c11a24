from __future__ import annotations

from intellwheels_maps import floor, scene
from intellwheels_maps.cast_places import cast_places
from intellwheels_schemas.messages import Cast


def test_agents_of_a_scene_have_their_places() -> None:
    assert cast_places(scene("figure6").cast, floor("room"))["chair3"] == "start3"


def test_agent_without_a_place_gets_the_first_for_its_kind_that_is_nobodys() -> None:
    cast = (
        Cast(name="a", robot="rear-wheel", mind="avoid"),
        Cast(name="b", command="./mine"),
        Cast(name="c", robot="person", mind="person", place="start1"),
        Cast(name="d", robot="car", mind="car"),
    )
    # No place of the room is for a car.
    assert cast_places(cast, floor("room")) == {"c": "start1", "a": "start2", "b": "start3"}
