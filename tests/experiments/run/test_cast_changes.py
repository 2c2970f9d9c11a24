from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_experiments.batch.experiment_rows import rows_of
from intellwheels_experiments.run.cast_changes import with_changes
from intellwheels_maps import scene
from intellwheels_schemas.errors import WireError


def test_changed_mind_and_options_are_in_the_cast() -> None:
    changed = with_changes(rows_of(scene("table1"))[2].scene, ["chair=driver"], ["chair.to=goal", "chair.speed=0.3"])
    (cast,) = changed.cast
    assert cast.mind == "driver"
    own, body = ({one.name for one in cast.option if one.name[0].isupper() is upper} for upper in (False, True))
    assert own == {"to", "speed"}
    assert body == {"MotorNoise", "Proximity.Model", "WheelRatio", "Encoders.Drift"}


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
