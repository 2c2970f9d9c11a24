"""Included minds are found by name, a user's own by the path of a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_agents import minds
from intellwheels_agents.options import OptionError, Options
from intellwheels_schemas.messages import Actions, Measures, Robot
from tests.agents.kinematics import RUN, context


def test_all_expected_minds_are_there() -> None:
    included = {
        "aided",
        "avoid",
        "car",
        "door",
        "drive",
        "driver",
        "follow",
        "joystick",
        "navigate",
        "person",
        "seek",
        "table",
    }
    assert {*included, "waypoints"} == set(minds.names())
    for name in minds.names():
        assert callable(minds.find(name).make)


def test_unknown_mind_is_refused_with_the_known_ones() -> None:
    with pytest.raises(OptionError, match=r"MIND: expected one of aided, avoid, .*, waypoints or a Python file"):
        minds.find("dance")


@pytest.mark.parametrize(
    "text",
    [
        "from intellwheels_agents import Actions\nclass Mind:\n    def __init__(self, context): pass\n"
        "    def decide(self, measures): return Actions(say='hi')\n",
        "from intellwheels_agents import Actions\nclass Own:\n    def decide(self, measures):\n"
        "        return Actions(say='hi')\ndef make(context): return Own()\n",
    ],
)
def test_users_file_defines_a_class_mind_or_make(tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    file = tmp_path / "json.py"
    file.write_text(text)
    source = minds.find(str(file))
    mind = source.make(context(Robot()))
    assert mind.decide(Measures(run=RUN, tick=0, time=0.0)) == Actions(say="hi")
    assert source.equip(Robot(), Options()) == Robot()


def test_file_without_a_mind_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    file = tmp_path / "mine.py"
    file.write_text("x = 1\n")
    with pytest.raises(OptionError, match=r"mine.py: expected make\(context\) or a class Mind, got neither"):
        minds.find(str(file))


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="expected a Python file, got none"):
        minds.find(str(tmp_path / "none.py"))
