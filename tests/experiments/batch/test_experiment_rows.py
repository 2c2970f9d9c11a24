from __future__ import annotations

import msgspec
import pytest

from intellwheels_experiments.batch.experiment_rows import rows_of
from intellwheels_maps import scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Bridge, Experiment, Level, Scene, Setting, Varied


def test_scene_without_factors_is_one_row() -> None:
    (row,) = rows_of(scene("figure6"))
    assert (row.name, row.real, row.arguments, dict(row.bridges)) == ("figure6", False, (), {})


def test_rows_are_every_combination_of_levels() -> None:
    rows = rows_of(scene("door"))
    assert len(rows) == 3 * 2 * 4 * 2
    assert rows[0].name == "v05+away+r20+t3"
    options = {one.name: one.value for one in rows[-1].scene.cast[0].option}
    assert options == {"left": "1.0", "right": "1.0"}


def test_level_replaces_the_cast_of_the_scene_and_sets_options() -> None:
    rows = {row.name: row for row in rows_of(scene("table1"))}
    assert rows["real-manual"].scene.cast[0].mind == "driver"
    assert rows["real-manual"].real
    real = rows["real-autonomous"].scene.cast[0]
    assert real.robot == "srf08-chair"
    assert {one.name: one.value for one in real.option} == {
        "MotorNoise": "0.015", "to": "goal", "WheelRatio": "1.002", "TrackRatio": "1.0", "Encoders.Drift": "0.00000034",
    }  # fmt: skip
    assert set(rows["augmented-raw"].bridges) == {"chair"}


def test_setting_without_an_agent_is_an_option_of_the_simulator() -> None:
    rows = {row.name: row for row in rows_of(scene("follow"))}
    assert rows["loss30"].arguments == ("--say-loss", "0.3")
    assert rows["silent"].arguments == ()


def test_options_about_hearing_are_settings() -> None:
    given = {"SayRange": "4", "SayLoss": "0.1", "SayDelay": "0.2", "SayWalls": "true"}
    settings = tuple(Setting(name=name, value=value) for name, value in given.items())
    levels = (Level(name="a", setting=settings), Level(name="b", setting=(Setting(name="SayWalls", value="false"),)))
    first, second = rows_of(_varied(*levels))
    assert first.arguments == ("--say-range", "4", "--say-loss", "0.1", "--say-delay", "0.2", "--say-walls")
    assert second.arguments == ("--no-say-walls",)
    with pytest.raises(WireError, match=r"Setting.Value: expected true or false, got 'perhaps'"):
        rows_of(_varied(Level(name="a", setting=(Setting(name="SayWalls", value="perhaps"),))))


def test_bridges_of_the_scene_are_in_every_row_unless_a_level_replaces_them() -> None:
    (row,) = rows_of(scene("lab"))
    assert (row.real, set(row.bridges)) == (True, {"real1", "real2"})
    other = Bridge(agent="real1", chair="intellwheels")
    varied = _varied(Level(name="a"), Level(name="b", bridge=(other,)), of="lab")
    first, second = rows_of(varied)
    assert first.bridges == row.bridges
    assert second.bridges == {**row.bridges, "real1": other}


def _varied(*levels: Level, of: str = "figure6") -> Scene:
    experiment = Experiment(subject="real1" if of == "lab" else "chair1", factor=(Varied(name="f", level=levels),))
    return msgspec.structs.replace(scene(of), experiment=experiment)


def test_unknown_setting_is_refused() -> None:
    level = Level(name="a", setting=(Setting(name="Gravity", value="1"),))
    experiment = Experiment(subject="chair1", factor=(Varied(name="f", level=(level,)),))
    with pytest.raises(WireError, match=r"Setting.Name: expected one of SayRange, .*, got 'Gravity'"):
        rows_of(msgspec.structs.replace(scene("figure6"), experiment=experiment))


def test_subject_of_a_scene_with_bridges_must_have_one() -> None:
    lab = scene("lab")
    with pytest.raises(WireError, match=r"expected an agent with a bridge \(real1, real2\), got 'virtual1'"):
        rows_of(msgspec.structs.replace(lab, experiment=Experiment(subject="virtual1")))


def test_subject_of_a_level_with_a_bridge_must_have_one() -> None:
    level = Level(name="a", bridge=(Bridge(agent="chair2"),))
    with pytest.raises(WireError, match=r"expected an agent with a bridge \(chair2\), got 'chair1'"):
        rows_of(_varied(level))


def test_laboratory_has_the_period_of_its_row() -> None:
    (row,) = rows_of(_varied(Level(name="a", setting=(Setting(name="Period", value="0.1"),)), of="lab"))
    assert (row.scene.period, row.arguments) == (0.1, ("--period", "0.1"))
    for wrong in ("soon", "0", "nan"):
        with pytest.raises(WireError, match=r"Setting.Value: expected a period in \[0.001, 1\] s, got '" + wrong):
            rows_of(_varied(Level(name="a", setting=(Setting(name="Period", value=wrong),))))
