"""What `iw-run` asks before it starts anything."""

from __future__ import annotations

import io
from pathlib import Path
from types import SimpleNamespace

import pytest

from intellwheels_agents.cast_check import check_cast, main
from intellwheels_agents.options import OptionError
from intellwheels_maps import names, scene
from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Cast, Option, Scene
from tests.every_case import every_case


def changed(name: str, agent: str, mind: str | None = None, **options: str) -> Scene:
    from msgspec.structs import replace

    found = scene(name)
    added = tuple(Option(name=option.replace("__", "."), value=value) for option, value in options.items())

    def change(cast: Cast) -> Cast:
        return replace(cast, mind=mind or cast.mind, option=(*(() if mind else cast.option), *added))

    return replace(found, cast=tuple(change(cast) if cast.name == agent else cast for cast in found.cast))


@every_case("name", names("scenes"))
def test_the_cast_of_every_included_scene_can_start(name: str) -> None:
    check_cast(scene(name), None)


@every_case(
    ("name", "agent", "mind", "options", "text"),
    [
        ("figure6", "chair1", None, {"sped": "1"}, "option sped: expected an option of this .* did you mean 'speed'"),
        ("figure6", "chair1", None, {"speed": "fast"}, r"option speed: expected a number in \[.*\], got 'fast'$"),
        ("figure6", "chair1", None, {"to": "gaol1"}, "option to: expected a place of the map .*; did you mean 'goal1'"),
        ("figure6", "chair1", None, {"MotorNose": "1"}, r"option MotorNose: expected a field .* mean MotorNoise\?$"),
        ("figure6", "chair1", "follo", {}, "expected one of aided, .* got 'follo'; did you mean 'follow'"),
        ("figure6", "chair1", "./none.py", {}, "none.py: expected a Python file, got none"),
        ("figure6", "door", None, {"swing": "up"}, "option swing: expected one of left, right, got 'up'"),
        ("lab", "real1", None, {"sped": "1"}, "option sped: expected an option of this mind"),
    ],
)  # fmt: skip
def test_a_wrong_mind_or_option_is_named_with_its_agent(
    name: str, agent: str, mind: str | None, options: dict[str, str], text: str
) -> None:
    with pytest.raises(OptionError, match=f"^agent '{agent}': .*{text}"):
        check_cast(changed(name, agent, mind, **options), None)


def test_a_robot_that_an_option_makes_too_long_for_its_place_is_found() -> None:
    with pytest.raises(OptionError, match=r"^agent 'chair1': expected a free place, got one in Wall"):
        check_cast(changed("figure6", "chair1", Part__Length="9"), None)


def test_a_users_mind_is_looked_for_in_the_folder_of_the_scene_and_not_run(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("raise SystemExit\nclass Mind:\n    pass\n")
    check_cast(changed("figure6", "chair1", "./mine.py"), tmp_path)


def test_the_first_fault_of_all_scenes_is_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = b"\n".join(map(encode, (scene("figure6"), changed("figure6", "chair2", sped="1"))))
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(lines)))
    assert main([]) == 2
    assert capsys.readouterr().err.startswith("agent 'chair2': option sped: expected an option of this mind")
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(encode(scene("figure6")))))
    assert main([]) == 0
    assert capsys.readouterr().err == ""
