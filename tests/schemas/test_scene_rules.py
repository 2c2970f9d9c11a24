"""Agents, rows and heights that a scene or a map names are those that it has."""

from __future__ import annotations

import msgspec
import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Bridge,
    Cast,
    Corner,
    Experiment,
    Level,
    Map,
    Obstacle,
    Option,
    Scene,
    Umbmark,
    Varied,
    Wall,
)
from intellwheels_schemas.rules import check
from intellwheels_schemas.scene_rules import check_map, check_scene


def refusal(message: Scene) -> str:
    with pytest.raises(WireError) as error:
        check(message)
    return error.value.text


@pytest.mark.parametrize(("document", "text"), [
    (Map(format="iw.v1", name="m", wall=(Wall(thickness=0.1, corner=(Corner(x=0.0, y=0.0),)),)),
     "Map.Wall[0]: expected at least 2 corners, got 1"),
    (Map(format="iw.v1", name="m", obstacle=(Obstacle(name="o", bottom=1.0, top=0.5, corner=(
        Corner(x=0.0, y=0.0), Corner(x=1.0, y=0.0), Corner(x=0.0, y=1.0))),)),
     "Map.Obstacle[0].Top: expected more than Bottom 1, got 0.5"),
])  # fmt: skip
def test_wall_and_obstacle_need_corners_and_height(document: Map, text: str) -> None:
    with pytest.raises(WireError) as error:
        check_map(document)
    assert error.value.text == text


def test_bridge_and_squares_are_of_what_the_scene_has() -> None:
    chair = Cast(name="a", robot="r", mind="m")
    lab = Scene(format="iw.v1", name="s", map="m", cast=(chair,), bridge=(Bridge(agent="b"),))
    assert refusal(lab) == "Scene.Bridge[0].Agent: expected an agent of the cast, got 'b'"
    twice = msgspec.structs.replace(lab, bridge=(Bridge(agent="a"), Bridge(agent="a")))
    assert refusal(twice) == "Scene.Bridge[1].Agent: expected each agent once, got 'a' twice"
    level = Level(name="x", bridge=(Bridge(agent="b"),))
    experiment = Experiment(subject="a", factor=(Varied(name="f", level=(level,)),))
    varied = msgspec.structs.replace(lab, bridge=(), experiment=experiment)
    assert (
        refusal(varied) == "Scene.Experiment.Factor[0].Level[0].Bridge[0].Agent: expected an agent of the cast, got 'b'"
    )
    squares = Experiment(
        subject="a",
        factor=(Varied(name="f", level=(Level(name="x"),)),),
        umbmark=Umbmark(left="x", right="y", side=4.0),
    )
    asked = msgspec.structs.replace(lab, bridge=(), experiment=squares)
    assert refusal(asked) == "Scene.Experiment.Umbmark.Right: expected a row (x), got 'y'"
    same = msgspec.structs.replace(squares, umbmark=Umbmark(left="x", right="x", side=4.0))
    asked = msgspec.structs.replace(lab, bridge=(), experiment=same)
    assert refusal(asked) == "Scene.Experiment.Umbmark.Right: expected another row than Left, got 'x'"


BRIDGE = Bridge(agent="a")


@pytest.mark.parametrize(
    ("cast", "bridges", "text"),
    [
        (Cast(name="a", robot="r"), (), "Scene.Cast[0]: expected a Mind or a Command, got neither"),
        (Cast(name="a", mind="m", command="c"), (), "Scene.Cast[0]: expected a Mind or a Command, got both"),
        (Cast(name="a", mind="m", folder="f"), (), "Scene.Cast[0].Folder: expected none without a Command, got 'f'"),
        (
            Cast(name="a", robot="r", command="c"),
            (),
            "Scene.Cast[0].Robot: expected none with a Command, whose program brings its own body, got 'r'",
        ),
        (
            Cast(name="a", command="c", option=(Option(name="MotorNoise", value="1"),)),
            (),
            "Scene.Cast[0].Option[0].Name: expected no option with a Command: write it into the line, got 'MotorNoise'",
        ),
        (
            Cast(name="a", robot="r", command="c", new_run="restart"),
            (BRIDGE,),
            "Scene.Cast[0].NewRun: expected follow for an agent with a Bridge, got 'restart'",
        ),
    ],
)
def test_agent_has_a_mind_or_a_command_and_nothing_that_would_be_ignored(
    cast: Cast, bridges: tuple[Bridge, ...], text: str
) -> None:
    scene = Scene(format="iw.v1", name="s", map="m", cast=(cast,), bridge=bridges)
    assert refusal(scene) == text
    if not bridges:
        level = Level(name="x", cast=(cast,))
        varied = Experiment(subject="a", factor=(Varied(name="f", level=(level,)),))
        other = msgspec.structs.replace(scene, cast=(Cast(name="b", mind="m"),), experiment=varied)
        assert refusal(other) == text.replace("Cast[0]", "Experiment.Factor[0].Level[0].Cast[0]")


def test_command_has_the_robot_of_a_bridge() -> None:
    cast = Cast(name="a", robot="r", command="c", option=(Option(name="MotorNoise", value="1"),))
    check_scene(Scene(format="iw.v1", name="s", map="m", cast=(cast,), bridge=(BRIDGE,)), "Scene")
