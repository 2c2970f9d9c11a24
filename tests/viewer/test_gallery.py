"""The command that takes the pictures, and the pictures that the repository keeps."""

from __future__ import annotations

import math
import os
import shutil
import sys
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from intellwheels_maps import library
from intellwheels_maps.library import robot
from intellwheels_schemas.messages import Scene
from intellwheels_viewer import gallery
from intellwheels_viewer.cameras import View, first_person
from intellwheels_viewer.drawings.door_frames import HEAD
from intellwheels_viewer.gallery import BEFORE_DOOR, IN_CORRIDOR, IN_LOBBY, PICTURES, SIZE, WARD, main, parser
from intellwheels_viewer.head_turn import eye_of
from tests.agents.arena import Arena
from tests.every_case import every_case
from tests.viewer.drawings.cast import entity
from tests.viewer.projection import in_picture

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "viewer" / "gallery"


@pytest.fixture
def ward_scene(tmp_path: Path) -> Scene:
    """The scene of the ward, as the command that runs it reads it."""
    (tmp_path / "enter-ward.xml").write_text(WARD)
    return library.scene(tmp_path / "enter-ward.xml")


def test_the_repository_keeps_ten_pictures_and_no_others() -> None:
    assert len(PICTURES) == 10
    assert {path.name for path in KEPT.iterdir()} == {f"{name}.jpg" for name in PICTURES}


@every_case("name", PICTURES)
def test_a_picture_has_the_size_of_the_page_and_few_bytes(name: str) -> None:
    file = KEPT / f"{name}.jpg"
    assert file.stat().st_size <= 120_000
    with Image.open(file) as picture:
        assert picture.size == SIZE


def test_the_picture_of_the_readme_is_one_of_them() -> None:
    assert "](viewer/gallery/free.jpg)" in (ROOT / "README.md").read_text()


def test_the_folder_is_the_one_of_the_checkout_unless_another_is_given() -> None:
    assert parser().parse_args([]).out == Path("viewer/gallery")
    assert parser().parse_args(["--out", "x"]).out == Path("x")


def test_without_playwright_it_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    assert main(["--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "gallery: pictures need playwright: pip install playwright\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.process
def test_a_command_that_ends_before_it_is_ready_is_told_with_its_words() -> None:
    with (
        pytest.raises(gallery.GalleryError, match=r"did not start:(.|\n)*no-such-scene"),
        gallery._started("view it at", "intellwheels_experiments", "no-such-scene"),
    ):
        pass


BETWEEN_PANELS: Final = (1280 - 2 * 292) / 800
"""Width over height of the scene in a picture."""


def view_of_chair1(arena: Arena, body: str) -> View:
    x, y, heading = arena.paths["chair1"][-1]
    return first_person(entity("chair1", x, y, heading=heading), eye_of(robot(body)))


def posts(arena: Arena, name: str) -> npt.NDArray[np.float64]:
    """Return the foot and the head of both posts of a doorway, (4, 3)."""
    (way,) = (each for each in arena.setup.floor.doorway if each.name == name)
    turn = math.radians(way.heading_deg)
    feet = [(way.x - side * math.sin(turn), way.y + side * math.cos(turn)) for side in (-way.width / 2, way.width / 2)]
    return np.array([(*foot, z) for foot in feet for z in (0.0, HEAD)])


def leaf(arena: Arena) -> npt.NDArray[np.float64]:
    """Return the corners of the leaf of the door, (4, 3)."""
    x, y, turn = arena.paths["door"][-1]
    return np.array(
        [(x - far * math.cos(turn), y - far * math.sin(turn), z) for far in (0.0, 0.99) for z in (0.0, 2.0)]
    )


def has_the_half_open_door_in_the_picture(scene: Scene, tick: int, body: str, doorway: str) -> bool:
    arena = Arena.of(scene)
    arena.run(tick * scene.period)
    opened = abs(math.remainder(arena.paths["door"][-1][2] - arena.paths["door"][0][2], math.tau))
    assert math.radians(40.0) < opened < math.radians(75.0)
    corners = np.concatenate([posts(arena, doorway), leaf(arena)])
    return bool(in_picture(view_of_chair1(arena, body), corners, BETWEEN_PANELS).all())


def test_the_driver_in_the_room_has_the_half_open_door_in_the_picture() -> None:
    assert has_the_half_open_door_in_the_picture(library.scene("figure6"), BEFORE_DOOR, "rear-wheel", "automatic-door")


def test_the_driver_in_the_lobby_has_the_half_open_door_in_the_picture(ward_scene: Scene) -> None:
    assert has_the_half_open_door_in_the_picture(ward_scene, IN_LOBBY, "mid-wheel", "ward-door")


def test_the_driver_in_the_corridor_has_doorways_on_both_sides_in_the_picture(ward_scene: Scene) -> None:
    arena = Arena.of(ward_scene)
    arena.run(IN_CORRIDOR * ward_scene.period)
    view = view_of_chair1(arena, "mid-wheel")
    for name in ("room2", "day-room"):
        assert in_picture(view, posts(arena, name), BETWEEN_PANELS).all(), name
    assert not arena.contacts()


@pytest.mark.soak
@pytest.mark.browser
def test_one_command_takes_all_ten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if shutil.which("chromium") is None and os.environ.get("REQUIRE_BROWSER") != "1":
        pytest.skip("no Chromium: the pictures are not taken; install chromium")
    assert main(["--out", str(tmp_path)]) == 0, capsys.readouterr().err
    assert {path.stem for path in tmp_path.iterdir()} == set(PICTURES)
