from __future__ import annotations

import msgspec
import pytest

from intellwheels_experiments.rows import rows_of
from intellwheels_maps import scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Experiment, Level, Setting, Varied


def test_scene_without_factors_is_one_row() -> None:
    (row,) = rows_of(scene("figure6"))
    assert (row.name, row.real, row.words, dict(row.bridges)) == ("figure6", False, (), {})


def test_rows_are_every_combination_of_levels() -> None:
    rows = rows_of(scene("door"))
    assert len(rows) == 3 * 2 * 4 * 2
    assert rows[0].name == "v05+away+r20+t3"
    options = {one.name: one.value for one in rows[-1].scene.cast[0].option}
    assert options == {"left": "1.0", "right": "1.0"}


def test_level_puts_its_cast_in_the_place_of_the_scenes_and_gives_it_options() -> None:
    rows = {row.name: row for row in rows_of(scene("table1"))}
    assert rows["real-manual"].scene.cast[0].mind == "driver"
    assert rows["real-manual"].real
    given = {one.name: one.value for one in rows["real-autonomous"].scene.cast[0].option}
    assert given == {
        "MotorNoise": "0.015", "to": "goal", "Proximity.Model": "sonar", "WheelRatio": "1.002",
        "Encoders.Drift": "0.00000034",
    }  # fmt: skip
    assert set(rows["augmented-raw"].bridges) == {"chair"}


def test_setting_without_an_agent_is_a_rule_of_the_simulation() -> None:
    rows = {row.name: row for row in rows_of(scene("follow"))}
    assert rows["loss30"].words == ("--say-loss", "0.3")
    assert rows["silent"].words == ()


def test_rule_that_there_is_not_is_refused() -> None:
    level = Level(name="a", setting=(Setting(name="Gravity", value="1"),))
    experiment = Experiment(subject="chair1", factor=(Varied(name="f", level=(level,)),))
    with pytest.raises(WireError, match=r"Setting.Name: expected a rule \(SayRange, .*\), got 'Gravity'"):
        rows_of(msgspec.structs.replace(scene("figure6"), experiment=experiment))
