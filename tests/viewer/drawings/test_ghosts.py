from __future__ import annotations

import math

import pytest
import viser

from intellwheels_schemas.agent_colours import COLOURS
from intellwheels_schemas.messages import Pose
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.ghosts import Ghost, Ghosts, reported, spirit
from intellwheels_viewer.drawings.looks import model_of
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.drawings.cast import node, robot
from tests.viewer.wire import body

BLUE = COLOURS[0]


def test_a_ghost_is_the_whole_body() -> None:
    assert len(spirit(robot("table")).faces) == model_of(robot("table")).triangles


def test_it_stands_at_its_pose_see_through_and_red_lined_when_refused(scene: viser.SceneApi) -> None:
    ghosts = Ghosts(scene)
    ghosts.show({"drag": Ghost(robot("crate"), 1.0, 2.0, math.pi, BLUE)})
    handle, lines = node(scene, "/ghosts/drag/body"), node(scene, "/ghosts/drag/outline")
    assert handle.position == pytest.approx([1.0, 2.0, 0.0])
    assert handle.wxyz == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=1e-7)
    assert handle.opacity == 0.4
    assert tuple(lines.color) == BLUE
    ghosts.show({"drag": Ghost(robot("crate"), 1.0, 2.0, math.pi, BLUE, refused=True)})
    assert tuple(lines.color) == palette.CONTACT
    assert node(scene, "/ghosts/drag/body") is handle


def test_it_goes_when_it_is_not_shown_and_changes_with_its_robot(scene: viser.SceneApi) -> None:
    ghosts = Ghosts(scene)
    ghosts.show({"place": Ghost(robot("crate"), 0.0, 0.0, 0.0, BLUE)})
    handle = node(scene, "/ghosts/place/body")
    ghosts.show({})
    assert not handle.visible
    ghosts.show({"place": Ghost(robot("table"), 0.0, 0.0, 0.0, BLUE)})
    assert node(scene, "/ghosts/place/body") is not handle


def test_a_real_chair_has_a_ghost_where_it_said_it_was() -> None:
    pose = Pose(x=1.0, y=2.0, heading=0.5)
    bodies = {"a": body("a")}
    (found,) = reported(Snapshot(bodies=bodies, reported={"a": pose, "gone": pose}), palette.Colours()).values()
    assert (found.robot, found.x, found.y, found.heading) == (bodies["a"].robot, 1.0, 2.0, 0.5)
    assert found.colour == palette.Colours().rgb("a")
