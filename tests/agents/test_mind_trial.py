from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_agents import Context, minds
from intellwheels_agents.mind import Mind
from intellwheels_agents.mind_trial import check_mind_file, check_mind_options
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.robot_document import default_robot
from intellwheels_maps import floor, robot
from intellwheels_schemas.messages import Robot


def check(mind: str, options: dict[str, str], **given: object) -> None:
    source = minds.find(mind)
    body = source.equip(robot("intellwheels"), Options({}))
    check_mind_options(source, body, options, **given)  # type: ignore[arg-type]


NEEDS_AN_OPTION = {"car", "driver", "follow", "seek", "waypoints"}
"""The minds that would stand for ever without an option. Others obey a user, or what their sensors see."""


@pytest.mark.parametrize("mind", sorted(NEEDS_AN_OPTION))
def test_a_mind_that_could_do_nothing_is_refused_before_it_joins(mind: str) -> None:
    body = minds.find(mind).equip(robot(default_robot(mind)), Options({}))
    with pytest.raises(OptionError, match=r"^options?( \w+)?: expected .*, got none$"):
        check_mind_options(minds.find(mind), body, {}, fetch_map=lambda: floor("room"))


@pytest.mark.parametrize("mind", sorted(set(minds.names()) - NEEDS_AN_OPTION - {"door", "person"}))
def test_included_minds_take_no_options_on_the_usual_chair(mind: str) -> None:
    check(mind, {}, fetch_map=lambda: floor("room"))


def test_a_wrong_option_is_found_without_a_simulator() -> None:
    with pytest.raises(OptionError, match=r"^option sped: expected an option of this mind .*; did you mean 'speed'\?$"):
        check("avoid", {"sped": "1"})
    with pytest.raises(OptionError, match=r"^option speed: expected a number in \[0, 5\], got '9'$"):
        check("avoid", {"speed": "9"})


def test_what_needs_the_map_is_left_to_the_run() -> None:
    check("waypoints", {"to": "nowhere", "sped": "1"})
    with pytest.raises(OptionError, match=r"^option to: expected a place of the map .*, got 'nowhere'"):
        check("waypoints", {"to": "nowhere"}, fetch_map=lambda: floor("room"))


def test_for_another_programs_body_only_options_count() -> None:
    bare = Robot(length=1.0, width=0.5)  # its sensors are those of another process

    def make(context: Context) -> Mind:
        if not context.robot.compass:
            raise OptionError("expected a robot with a compass, got none")
        raise AssertionError

    source = minds.Source("needs-a-compass", make, lambda robot, _: robot)
    with pytest.raises(OptionError, match=r"^expected a robot with a compass, got none$"):
        check_mind_options(source, bare, {})
    check_mind_options(source, bare, {}, own_body=False)
    with pytest.raises(OptionError, match=r"^option speed: "):
        check_mind_options(minds.find("avoid"), bare, {"speed": "9"}, own_body=False)


def test_a_users_file_is_never_tried(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("class Mind:\n    def __init__(self, context):\n        raise RuntimeError\n")
    check(str(file), {"any": "1"})


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("class Mind: ...", None),
        ("def make(context): ...", None),
        ("from base import Mind", None),
        ("from base import Fast as Mind", None),
        ("from base import *", None),
        ("try:\n    from fast import Mind\nexcept ImportError:\n    from slow import Mind", None),
        ("if True:\n    class Mind: ...", None),
        ("import base\nMind = base.Mind", None),
        ("class Other: ...", "expected make(context) or a class Mind, got neither"),
        ("class Mind(:", ":1: expected Python, got a syntax error: "),
    ],
)
def test_a_file_is_read_for_what_it_defines(text: str, error: str | None, tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(text)
    if error is None:
        check_mind_file(file)
        return
    with pytest.raises(OptionError) as caught:
        check_mind_file(file)
    assert error in str(caught.value)
    with pytest.raises(OptionError, match=r"none\.py: expected a Python file, got none"):
        check_mind_file(tmp_path / "none.py")
