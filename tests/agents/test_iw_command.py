"""`iw`: one name for all commands, lists of what is included, completion."""

import subprocess

import pytest

from intellwheels_agents.iw_command import COMMANDS, about, main
from intellwheels_maps import names
from tests.commands import SCRIPTS
from tests.every_case import every_case


def test_every_command_of_the_distribution_has_a_line_in_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    listed = {name.removeprefix("iw-") for name in SCRIPTS if name != "iw"}
    assert listed == COMMANDS.keys()
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    printed = capsys.readouterr().out
    assert all(f"  iw {name} " in printed for name in listed)


def test_what_a_command_does_is_the_first_line_of_its_docstring() -> None:
    assert about("intellwheels_agents.bridge") == "puts a real chair into a simulation"
    assert about("intellwheels_agents.__main__") == "runs one agent as a process of its own"
    assert all(len(text) > 20 and "`" not in text[:1] for text in COMMANDS.values())


@every_case("name", COMMANDS)
def test_a_command_gets_its_own_options(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: iw-{name}")


def test_without_a_command_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "iw list places ward" in capsys.readouterr().out


def test_a_mistyped_command_gets_a_suggestion(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["veiwer"]) == 2
    assert capsys.readouterr().err.rstrip().endswith("got 'veiwer'; did you mean 'viewer'?")


@pytest.mark.parametrize("kind", ["floors", "robots", "scenes"])
def test_list_has_every_included_file(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", kind]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert listed == names(kind)  # type: ignore[arg-type]


def test_maps_are_listed_under_both_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "floors"]) == main(["list", "maps"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[: len(lines) // 2] == lines[len(lines) // 2 :]


def test_list_has_minds_with_what_they_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "minds"]) == 0
    lines = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert {"avoid", "waypoints", "person"} <= lines.keys()
    assert all(len(text) > 20 for text in lines.values())


def test_list_has_the_places_of_a_floor_with_their_poses(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "places", "ward"]) == 0
    lines = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert lines["lobby1"].startswith("x=-3.8 y=1.6 heading=0 deg")


@pytest.mark.parametrize(("words", "text"), [
    (["list", "places"], "expected a MAP after places, got none"),
    (["list", "minds", "ward"], "expected no MAP after minds, got 'ward'"),
    (["list", "flors"], "KIND: expected one of floors, maps, robots, scenes, minds, places, got 'flors'; did you mean"),
])  # fmt: skip
def test_wrong_lists_are_refused(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert text in capsys.readouterr().err


def test_places_of_an_unknown_floor_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "places", "wrad"]) == 2
    assert "got 'wrad'; did you mean 'ward'?" in capsys.readouterr().err


@pytest.mark.process
def test_completion_is_a_script_that_knows_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    (known,) = [line for line in script.splitlines() if line.startswith("_shtab_iw_subparsers=")]
    assert {*COMMANDS, "list"} <= set(known.split("(")[1].rstrip(")").replace("'", "").split())
    subprocess.run(["bash", "-n"], input=script, text=True, check=True, timeout=10)
