from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_experiments.batch.experiment_rows import rows_of
from intellwheels_experiments.run.cast_changes import with_changes
from intellwheels_maps import scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Experiment, Level, Scene, Varied


def test_changed_mind_and_options_are_in_the_cast() -> None:
    changed = with_changes(rows_of(scene("table1"))[2].scene, ["chair=driver"], ["chair.to=goal", "chair.speed=0.3"])
    (cast,) = changed.cast
    assert cast.mind == "driver"
    own, body = ({one.name for one in cast.option if one.name[0].isupper() is upper} for upper in (False, True))
    assert own == {"to", "speed"}
    assert body == {"MotorNoise", "WheelRatio", "TrackRatio", "Encoders.Drift"}


@pytest.mark.parametrize(
    ("minds", "options"), [(["nobody=drive"], []), (["chair"], []), ([], ["chair.WheelRatio=1"]), ([], ["chair=1"])]
)
def test_impossible_change_is_refused(minds: list[str], options: list[str]) -> None:
    with pytest.raises(WireError, match="expected AGENT"):
        with_changes(rows_of(scene("table1"))[2].scene, minds, options, robot_fields=False)


def test_file_of_a_mind_starts_at_the_folder_of_the_command() -> None:
    changed = with_changes(scene("figure6"), ["chair1=./mine.py"], [])
    assert changed.cast[0].mind == str(Path.cwd() / "mine.py")


def test_field_of_a_robot_is_changed_too() -> None:
    changed = with_changes(scene("figure6"), [], ["chair1.MotorNoise=0.1"])
    assert any(option.name == "MotorNoise" and option.value == "0.1" for option in changed.cast[0].option)


def test_command_replaces_the_mind_its_options_and_its_robot_and_starts_in_the_working_directory() -> None:
    changed = with_changes(scene("figure6"), [], [], ["chair1=./mine {name} --at={endpoint}"])
    chair1, chair2 = changed.cast[:2]
    assert chair1 == Cast(
        name="chair1", command="./mine {name} --at={endpoint}", folder=str(Path.cwd()), place="start1"
    )
    assert chair2 == scene("figure6").cast[1]


def test_command_of_a_chair_with_a_bridge_keeps_the_robot() -> None:
    before = scene("lab")
    agent = before.bridge[0].agent
    (cast,) = [one for one in with_changes(before, [], [], [f"{agent}=./mine"]).cast if one.name == agent]
    (old,) = [one for one in before.cast if one.name == agent]
    assert (cast.robot, cast.command, cast.mind) == (old.robot, "./mine", "")
    assert all(option.name[0].isupper() for option in cast.option)


def test_mind_replaces_a_command() -> None:
    by_command = with_changes(scene("figure6"), [], [], ["chair1=./mine"])
    chair1 = with_changes(by_command, ["chair1=avoid"], ["chair1.speed=0.2"]).cast[0]
    assert (chair1.mind, chair1.command, chair1.folder) == ("avoid", None, None)
    assert [option.name for option in chair1.option] == ["speed"]


def test_agent_of_a_level_is_changed_too() -> None:
    level = Level(name="x", cast=(Cast(name="chair", robot="rear-wheel", mind="drive"),))
    varied = Experiment(subject="chair", factor=(Varied(name="f", level=(level,)),))
    before = Scene(format="iw.v1", name="s", map="room", experiment=varied)
    (row,) = rows_of(with_changes(before, [], [], ["chair=./mine {name}"]))
    assert [(cast.name, cast.command) for cast in row.scene.cast] == [("chair", "./mine {name}")]


def test_level_that_sets_an_option_of_a_program_is_refused() -> None:
    changed = with_changes(scene("table1"), [], [], ["chair=./mine"])
    with pytest.raises(WireError, match=r"Setting.Agent: expected an agent with a mind, got 'chair'"):
        rows_of(changed)


@pytest.mark.parametrize(
    ("minds", "options", "commands", "text"),
    [
        ([], [], ["chir1=./mine"], "agent of the scene (chair1, chair2, chair3, table, door), got 'chir1=./mine'; "
         "did you mean 'chair1'?"),
        ([], [], ["chair1="], "--command: expected AGENT=COMMAND"),
        ([], [], ["chair1=./mine {nam}"], "--command: chair1: expected the placeholders {name}, {endpoint}, {world}"),
        (["chair1=avoid"], [], ["chair1=./mine"], "--command: expected one --mind or --command for 'chair1', got two"),
        ([], ["chair1.speed=1"], ["chair1=./mine"], "--option: expected an agent with a mind, got 'chair1'"),
    ],
)  # fmt: skip
def test_wrong_change_is_refused_in_words(minds: list[str], options: list[str], commands: list[str], text: str) -> None:
    with pytest.raises(WireError) as error:
        with_changes(scene("figure6"), minds, options, commands)
    assert text in error.value.text


def test_change_of_a_scene_without_agents_says_that_it_has_none() -> None:
    with pytest.raises(WireError, match=r"with an agent of the scene \(it has none\), got 'a=avoid'"):
        with_changes(Scene(format="iw.v1", name="empty", map="room"), ["a=avoid"], [], [])
