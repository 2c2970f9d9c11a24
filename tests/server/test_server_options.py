"""The options of `iw-server` that make a world what it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Corner, Map, Wall
from intellwheels_server.__main__ import main
from intellwheels_server.server_options import check_walls, options_of, parser


def test_rules_of_speech_are_options_without_a_default_of_their_own() -> None:
    given = parser().parse_args([])
    assert (given.say_walls, given.say_loss, given.say_delay, given.say_range) == (None, None, None, None)
    given = parser().parse_args(["--say-walls", "--say-loss", "0.3", "--say-delay", "0.2"])
    assert (given.say_walls, given.say_loss, given.say_delay) == (True, 0.3, 0.2)


@pytest.mark.parametrize(
    ("option", "text"),
    [
        ("--say-loss", "expected a share in [0, 1], got '1.5'"),
        ("--say-delay", "expected seconds in [0, 3600], got '1e9'"),
    ],
)
def test_share_or_time_out_of_range_is_wrong_usage(option: str, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main([option, text.rsplit(" ", 1)[1].strip("'")])
    assert left.value.code == 2
    assert text in capsys.readouterr().err


SAYING = """\
<Scene Format="iw.v1" Name="say" Map="room" SayRange="4" SayWalls="true" SayLoss="0.3" SayDelay="0.2"/>
"""


def test_command_line_overrides_the_rules_of_speech_of_a_scene(tmp_path: Path) -> None:
    path = tmp_path / "say.xml"
    path.write_text(SAYING)
    for words, wanted in (
        ([], (8.0, False, 0.0, 0.0)),
        (["--scene", str(path)], (4.0, True, 0.3, 0.2)),
        (["--scene", str(path), "--say-loss", "0.0", "--no-say-walls"], (4.0, False, 0.0, 0.2)),
    ):
        setup = options_of(parser().parse_args(["--world", "main", *words]))[0].setup
        assert (setup.say_range, setup.say_walls, setup.say_loss, setup.say_delay) == wanted


def test_walls_that_the_world_cannot_take_are_refused_before_anything_starts() -> None:
    """A check of its own, as the map of a scene or a log may not have been checked."""
    wall = Wall(height=2.0, thickness=1e-10, corner=(Corner(x=0.0, y=0.0), Corner(x=1.0, y=0.0)))
    with pytest.raises(WireError, match=r"^--map: made: wall 0: expected a thickness of at least 1e-09 m, got 1e-10$"):
        check_walls(Map(format="iw.v1", name="made", wall=(wall,)))


def test_places_of_a_scene_are_kept_for_its_agents_or_as_the_command_line_says() -> None:
    def reserved(*words: str) -> dict[str, str]:
        given = parser().parse_args(words)
        given.world = "main"
        return dict(options_of(given)[0].reserved)

    assert reserved("--scene", "figure6") == {
        "chair1": "start1", "chair2": "start2", "chair3": "start3", "table": "table", "door": "hinge",
    }  # fmt: skip
    assert reserved("--map", "room") == {}
    assert reserved("--map", "room", "--reserve", "a=start1", "--reserve", "b=start2") == {"a": "start1", "b": "start2"}
    with pytest.raises(
        ValueError, match=r"--reserve: expected AGENT=PLACE with a place of the map \(start1, .*got 'a'"
    ):
        reserved("--map", "room", "--reserve", "a")
