"""What an experiment draws for each seed: options of agents and bridges, places and obstacles of the map."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.seed_variation import (
    check_variation,
    drawn,
    label_of,
    offset_of,
    varied_floor,
    varied_row,
    write_scene,
)
from intellwheels_maps import floor, scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Uniform
from tests.experiments.scenes import write_scene as write_short

RATIO = '<Uniform Agent="chair" Name="WheelRatio" Low="-0.004" High="0.004"/>'
FLOOR = floor("corridor15m")


def rows(folder: Path, common: str = "", level: str = "", *, laboratory: bool = False) -> dict[str, Row]:
    """Return the rows of the short scene, with elements of its experiment and of its level `unlike`."""
    path = write_short(folder, laboratory=laboratory)
    text = path.read_text().replace('<Factor Name="wheels">', f'{common}<Factor Name="wheels">')
    setting = '<Setting Agent="chair" Name="WheelRatio" Value="1.02"/>'
    path.write_text(text.replace(f"{setting}</Level>", f"{setting}{level}</Level>"))
    return {row.name: row for row in rows_of(scene(str(path)))}


def options(row: Row) -> dict[str, str]:
    return {option.name: option.value for option in row.scene.cast[0].option}


def test_offsets_are_uniform_and_follow_from_seed_and_number_alone() -> None:
    uniform = Uniform(place="start", name="Y", low=-0.2, high=0.6)
    values = np.array([offset_of(uniform, str(seed)) for seed in range(4000)])
    assert values.min() >= -0.2
    assert values.max() <= 0.6
    # Kolmogorov-Smirnov: 1.95 / sqrt(n) is passed by 1 sample in 1,000.
    found = np.sort((values + 0.2) / 0.8)
    assert np.abs(found - (np.arange(4000) + 0.5) / 4000).max() < 1.95 / np.sqrt(4000)
    assert offset_of(uniform, "7") == values[7]
    other = np.array([offset_of(Uniform(place="start", name="X", low=-0.2, high=0.6), str(s)) for s in range(4000)])
    assert abs(np.corrcoef(values, other)[0, 1]) < 3.3 / np.sqrt(4000)


def test_option_gets_its_offset_in_the_rows_of_its_level(tmp_path: Path) -> None:
    found = rows(tmp_path, level=RATIO)
    equal, unlike = (varied_row(found[name], "3") for name in ("equal", "unlike"))
    assert equal == found["equal"]
    offset = drawn(found["unlike"], "3")["chair.WheelRatio"]
    assert abs(offset) <= 0.004
    assert float(options(unlike)["WheelRatio"]) == pytest.approx(1.02 + offset, abs=1e-12)
    assert options(unlike) | {"WheelRatio": ""} == options(found["unlike"]) | {"WheelRatio": ""}
    assert options(varied_row(found["unlike"], "4"))["WheelRatio"] != options(unlike)["WheelRatio"]


def test_field_of_a_real_chair_is_that_of_its_bridge(tmp_path: Path) -> None:
    found = rows(tmp_path, laboratory=True)["real"]
    with_range = varied_row(
        Row(found.name, found.title, found.real, found.scene, (), found.bridges,
            (Uniform(agent="chair", name="WheelRatio", low=-0.01, high=0.01),)), "1",
    )  # fmt: skip
    (option,) = with_range.bridges["chair"].option
    assert float(option.value) == pytest.approx(1.02 + drawn(with_range, "1")["chair.WheelRatio"], abs=1e-12)
    assert with_range.scene == found.scene


def test_calibration_follows_what_it_measures(tmp_path: Path) -> None:
    follows = '<Uniform Agent="chair" Name="left" Low="-0.001" High="0.001" Follows="WheelRatio"/>'
    row = rows(tmp_path, level=RATIO + follows)["unlike"]
    for seed in "123":
        found = drawn(row, seed)
        assert abs(found["chair.left"] - found["chair.WheelRatio"]) <= 0.001
        assert found["chair.left"] != found["chair.WheelRatio"]
        assert float(options(varied_row(row, seed))["left"]) == pytest.approx(0.5 + found["chair.left"], abs=1e-12)


def test_range_of_a_level_replaces_that_of_the_experiment(tmp_path: Path) -> None:
    wide = RATIO.replace("0.004", "0.1")
    found = rows(tmp_path, common='<Uniform Place="start" Name="Y" Low="-0.1" High="0.1"/>' + wide, level=RATIO)
    assert [(label_of(one), one.high) for one in found["unlike"].uniform] == [
        ("place start.Y", 0.1), ("chair.WheelRatio", 0.004)
    ]  # fmt: skip
    assert drawn(found["equal"], "1")["place start.Y"] == drawn(found["unlike"], "1")["place start.Y"]


def test_places_and_obstacles_move(tmp_path: Path) -> None:
    common = (
        '<Uniform Place="start" Name="Y" Low="-0.1" High="0.1"/><Uniform Obstacle="a" Name="X" Low="-0.2" High="0.2"/>'
        '<Uniform Place="start" Name="HeadingDeg" Low="170" High="190"/>'
    )
    row = rows(tmp_path, common=common)["equal"]
    offsets = drawn(row, "2")
    found = varied_floor(FLOOR, row, "2")
    assert FLOOR.grid is not None
    assert found.grid is not None
    before, after = FLOOR.grid.position[0], found.grid.position[0]
    assert after.y == pytest.approx(before.y + offsets["place start.Y"], abs=1e-6)
    assert after.x == before.x
    assert -180.0 <= after.heading_deg <= 180.0
    turned = after.heading_deg - before.heading_deg - offsets["place start.HeadingDeg"]
    assert math.remainder(turned, 360.0) == pytest.approx(0.0, abs=1e-6)
    moved = [(new.x - old.x, new.y - old.y) for new, old in
             zip(found.obstacle[0].corner, FLOOR.obstacle[0].corner, strict=True)]  # fmt: skip
    assert np.array(moved) == pytest.approx(np.array([[offsets["obstacle a.X"], 0.0]] * 4), abs=1e-6)
    assert found.obstacle[1] == FLOOR.obstacle[1]
    assert found.grid.position[1] == FLOOR.grid.position[1]


def test_files_of_a_run_hold_its_scene_and_map(tmp_path: Path) -> None:
    row = rows(tmp_path, common='<Uniform Place="start" Name="Y" Low="-0.1" High="0.1"/>')["equal"]
    moved = varied_floor(FLOOR, row, "2")
    file, written = write_scene(tmp_path, row, "2", moved)
    read = scene(str(file))
    assert (read.seed, read.map) == ("2", written.scene.map)
    assert floor(read.map) == moved


@pytest.mark.parametrize(
    ("common", "text"),
    [
        ('<Uniform Agent="chair" Name="WheelRatio" Low="0" High="1"/>',
         "Uniform.Name: expected an option of 'chair' that row 'equal' sets, got 'WheelRatio'"),
        ('<Uniform Place="there" Name="X" Low="0" High="1"/>',
         "Uniform.Place: expected one of map 'corridor15m' (start, goal), got 'there'"),
        ('<Uniform Obstacle="c" Name="X" Low="0" High="1"/>',
         "Uniform.Obstacle: expected one of map 'corridor15m' (a, b), got 'c'"),
        ('<Uniform Agent="chair" Name="left" Low="0" High="1" Follows="right"/>',
         "Uniform.Follows: expected an option of 'chair' that row 'equal' draws by itself, got 'right'"),
        ('<Uniform Agent="chair" Name="left" Low="0" High="1" Follows="right"/>'
         '<Uniform Agent="chair" Name="right" Low="0" High="1" Follows="left"/>',
         "Uniform.Follows: expected an option of 'chair' that row 'equal' draws by itself, got 'right'"),
    ],
)  # fmt: skip
def test_what_is_not_there_is_refused_before_anything_starts(tmp_path: Path, common: str, text: str) -> None:
    with pytest.raises(WireError) as caught:
        check_variation(list(rows(tmp_path, common=common).values()), FLOOR)
    assert caught.value.text == text


def test_option_that_is_no_number_is_refused(tmp_path: Path) -> None:
    row = rows(tmp_path)["equal"]
    text = tmp_path / "short.xml"
    text.write_text(text.read_text().replace('Name="left" Value="0.5"', 'Name="left" Value="fast"'))
    (row, _) = rows_of(scene(str(text)))
    ranged = Row(
        row.name, row.title, row.real, row.scene, (), {}, (Uniform(agent="chair", name="left", low=0, high=1),)
    )
    with pytest.raises(
        WireError, match="expected an option of 'chair' that is a number in row 'equal', got left='fast'"
    ):
        check_variation([ranged], FLOOR)
