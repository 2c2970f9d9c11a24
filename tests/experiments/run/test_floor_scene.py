"""A floor runs as a scene: alone, or with an agent for each leaf of its doors."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_experiments.__main__ import main
from intellwheels_experiments.run.floor_scene import FLOOR_SECONDS, write_floor_scene
from intellwheels_experiments.run_parser import parser
from intellwheels_maps import scene
from intellwheels_schemas.errors import WireError

FLOOR = """<Map Format="iw.v1" Name="hall">
  <Wall Thickness="0.1"><Corner X="0" Y="0.5"/><Corner X="0" Y="3"/></Wall>
  <Wall Thickness="0.1"><Corner X="0" Y="-3"/><Corner X="0" Y="-0.5"/></Wall>
  <Doorway Name="d" X="0" Y="0" HeadingDeg="0" Width="1"><Door Kind="{kind}"/></Doorway>
  <Grid><Position Name="start" X="-2" Y="0"/><Position Name="goal" X="2" Y="0" Kinds="goal"/></Grid>
</Map>
"""


def hall(folder: Path, kind: str) -> str:
    file = folder / "hall.xml"
    file.write_text(FLOOR.format(kind=kind))
    return str(file)


def test_a_floor_alone_has_no_agents(tmp_path: Path) -> None:
    written = scene(write_floor_scene("ward", tmp_path, doors=False, forever=False))
    assert written.cast == ()
    assert written.pace == "free"  # lockstep would wait for an agent
    assert written.end is not None
    assert written.end.timeout is not None
    assert written.end.timeout.seconds == FLOOR_SECONDS


@pytest.mark.parametrize(("kind", "leaves"), [("hinged", 1), ("double-sliding", 2)])
def test_leaves_are_agents_of_the_scene(tmp_path: Path, kind: str, leaves: int) -> None:
    written = scene(write_floor_scene(hall(tmp_path, kind), tmp_path, doors=True, forever=True))
    assert [cast.mind for cast in written.cast] == ["door"] * leaves
    assert written.end is None


def test_a_floor_without_doors_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WireError, match=r"--doors: expected a floor with doors, got 'ward' without"):
        write_floor_scene("ward", tmp_path, doors=True, forever=False)
    with pytest.raises(WireError, match=r"--floor: .*expected one of the maps"):
        write_floor_scene("wart", tmp_path, doors=False, forever=False)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ([], "SCENE: expected either a scene or --floor, got none"),
        (["door", "--floor", "ward"], "SCENE: expected either a scene or --floor, got both"),
        (["door", "--doors"], "--doors: expected with --floor, got a scene"),
        (["--floor", "ward", "--doors"], "--doors: expected a floor with doors, got 'ward' without"),
        (["--floor", "ward", "--seeds", "2"], "--floor: expected with a single run"),
    ],
)
def test_wrong_usage_is_one_line(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert capsys.readouterr().err.startswith(f"iw-run: {text}")


def test_the_option_has_the_name_that_the_simulator_gives_it_too() -> None:
    assert parser().parse_args(["--map", "ward"]).floor == parser().parse_args(["--floor", "ward"]).floor == "ward"
