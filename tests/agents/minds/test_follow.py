"""Following by messages, in the simulated world: the scene `follow` with its noise."""

from __future__ import annotations

import math

import pytest
from shapely import affinity
from shapely.geometry import LineString, MultiPolygon, Point, box
from shapely.ops import unary_union

from intellwheels_agents.options import OptionError
from intellwheels_maps import scene
from intellwheels_schemas.rules import parts_of
from tests.agents.arena import Arena

FOLLOWERS = ("follower1", "follower2")


def arrived(arena: Arena) -> bool:
    there = math.dist(arena.paths["leader"][-1][:2], (11.2, 12.5)) < 0.3
    return there and all(abs(arena.speed(name)) < 1e-3 for name in ("leader", *FOLLOWERS))


def outline(arena: Arena, name: str, tick: int) -> MultiPolygon:
    x, y, heading = arena.paths[name][tick]
    shape = unary_union(
        [
            box(part.x - part.length / 2, part.y - part.width / 2, part.x + part.length / 2, part.y + part.width / 2)
            for part in parts_of(arena.state.body_set.models[name].robot)
        ]
    )
    turned = affinity.rotate(shape, heading, origin=(0.0, 0.0), use_radians=True)
    moved: MultiPolygon = affinity.translate(turned, x, y)
    return moved


@pytest.mark.parametrize("seed", ["1", "2", "3"])
def test_two_followers_keep_to_the_leaders_path_and_their_distance(seed: str) -> None:
    arena = Arena.of(scene("follow"), seed)
    assert arena.run(90.0, arrived) < 90.0
    assert arena.contacts() == []
    begins = [arena.paths[name][0][:2] for name in reversed(FOLLOWERS)]
    path = LineString([*begins, *(pose[:2] for pose in arena.paths["leader"])])
    for name in FOLLOWERS:
        off = [path.distance(Point(pose[:2])) for pose in arena.paths[name]]
        assert math.sqrt(sum(metres * metres for metres in off) / len(off)) < 0.25
    for tick in range(0, len(arena.paths["leader"]), 5):
        one, two, three = (outline(arena, name, tick) for name in ("leader", *FOLLOWERS))
        assert min(one.distance(two), two.distance(three)) > 0.3


def test_followers_of_a_silent_leader_stop_within_three_and_a_half_seconds() -> None:
    arena = Arena.of(scene("follow"))
    arena.run(8.0)
    assert all(arena.speed(name) > 0.3 for name in FOLLOWERS)
    arena.players["leader"].muted = True
    last_word = arena.said["leader"][-1][0] * 0.05
    arena.run(last_word + 3.5 - arena.state.time)
    assert [arena.speed(name) for name in FOLLOWERS] == [pytest.approx(0.0, abs=1e-3)] * 2


def test_leader_that_resumes_is_followed_again() -> None:
    arena = Arena.of(scene("follow"))
    arena.run(8.0)
    arena.players["leader"].muted = True
    arena.run(5.0)
    arena.players["leader"].muted = False
    arena.run(3.0)
    assert all(arena.speed(name) > 0.3 for name in FOLLOWERS)


def test_follower_without_messages_stands() -> None:
    arena = Arena("corner")
    arena.join("alone", "follow", "mid-wheel", "follower1", {"leader": "nobody"})
    arena.run(2.0)
    assert arena.paths["alone"][-1] == arena.paths["alone"][0]


def test_robot_without_encoders_cannot_follow() -> None:
    with pytest.raises(OptionError, match="expected a robot with encoders"):
        Arena("corner").join("blind", "follow", "crate", "follower1", {"leader": "leader"})


@pytest.mark.parametrize(("given", "got"), [({}, "none"), ({"leader": "one, two"}, "'one two'")])
def test_no_leader_and_two_leaders_are_refused(given: dict[str, str], got: str) -> None:
    with pytest.raises(OptionError, match=f"option leader: expected the name of the agent to follow, got {got}"):
        Arena("corner").join("torn", "follow", "mid-wheel", "follower1", given)
