"""The command that takes the pictures, and the pictures that the repository keeps."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from PIL import Image

from intellwheels_viewer import gallery
from intellwheels_viewer.gallery import PICTURES, SIZE, main, parser
from tests.every_case import every_case

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "viewer" / "gallery"


def test_the_repository_keeps_eight_pictures_and_no_others() -> None:
    assert len(PICTURES) == 8
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


@pytest.mark.soak
@pytest.mark.browser
def test_one_command_takes_all_eight(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if shutil.which("chromium") is None and os.environ.get("REQUIRE_BROWSER") != "1":
        pytest.skip("no Chromium: the pictures are not taken; install chromium")
    assert main(["--out", str(tmp_path)]) == 0, capsys.readouterr().err
    assert {path.stem for path in tmp_path.iterdir()} == set(PICTURES)
