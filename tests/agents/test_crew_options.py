from __future__ import annotations

import pytest

from intellwheels_agents.__main__ import main, parser
from intellwheels_agents.crew_options import check_crew_options, crew_name, numbered
from intellwheels_agents.options import OptionError
from intellwheels_schemas.errors import WireError


def test_names_places_and_options_have_the_number() -> None:
    one, two = numbered(2, "chair", "bed{n}", {"to": "goal{n}", "speed": "0.5"})
    assert one == ("chair1", "bed1", {"to": "goal1", "speed": "0.5"})
    assert two == ("chair2", "bed2", {"to": "goal2", "speed": "0.5"})
    assert [each.name for each in numbered(2, "a{n}-b", None, {})] == ["a1-b", "a2-b"]


@pytest.mark.parametrize("name", ["Chair", "{n}chair", "x" * 32])
def test_wrong_names_are_refused(name: str) -> None:
    with pytest.raises(WireError, match="--name"):
        list(numbered(1, name, None, {}))


@pytest.mark.parametrize(
    ("words", "name", "crew"),
    [((), "chair", "chair"), ((), "chair{n}", "chair"), ((), "a-{n}-b", "a-b"), (("--crew", "x"), "chair", "x")],
)
def test_crew_has_the_name_of_its_agents_without_the_number(words: tuple[str, ...], name: str, crew: str) -> None:
    assert crew_name(parser().parse_args(["avoid", "--count", "2", *words]), name) == crew


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--crew", "x"), "--crew: expected with --count only"),
        (("--count", "2", "--numbered"), "--numbered: expected without --count"),
        (("--count", "2", "--position", "1,2,3"), "--position: expected without --count"),
        (("--count", "2", "--role", "body"), "--count: expected the role both or mind, got body"),
        (("--count", "2", "--place", "bed1"), r"--place: expected one place with \{n\}"),
        (("--count", "1", "--place", "a", "--place", "b"), "--place: expected one place"),
    ],
)
def test_what_contradicts_a_count_is_refused(words: tuple[str, ...], text: str) -> None:
    with pytest.raises(OptionError, match=text):
        check_crew_options(parser().parse_args(["avoid", *words]))


@pytest.mark.parametrize("count", ["0", "251", "-1", "x", "1.5"])
def test_wrong_counts_are_wrong_usage(count: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        parser().parse_args(["avoid", "--count", count])
    assert caught.value.code == 2
    assert "from 1 to 250" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [("--option", "speed=x{n}"), ("--option", "nothing=1"), ("--name", "Chair"), ("--crew", "X")]
)
def test_wrong_members_are_found_before_anything_starts(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["waypoints", "--count", "3", *words, "--retry-for", "1"]) == 2
    assert capsys.readouterr().err.startswith("iw-agent: ")
