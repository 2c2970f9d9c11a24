"""Wrong usages, made from every option of every command: each ends with one line and exit code 2.

The line names the option, what was expected and what came. Nothing is started: these tests are not marked `process`,
so a child process or a connection fails them. Nothing is written. `WRONG` says which values are wrong for a kind of
option. An option of a new kind, or a command without an entry in `COMMANDS`, fails here.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import pytest

from intellwheels_agents import __main__ as agent
from intellwheels_agents.bridge import __main__ as bridge
from intellwheels_agents.bridge import firmware_stand_in, luci_stand_in, rnet_stand_in
from intellwheels_agents.ciber_gateway import __main__ as ciber
from intellwheels_agents.iw_command import main as iw
from intellwheels_agents.joystick import __main__ as joystick
from intellwheels_agents.joystick import joystick_options
from intellwheels_agents.record_gateway import __main__ as record
from intellwheels_agents.ros_gateway import __main__ as ros
from intellwheels_experiments import __main__ as run
from intellwheels_experiments import run_parser
from intellwheels_experiments.conformance import __main__ as check_agent
from intellwheels_maps import __main__ as maps
from intellwheels_schemas import __main__ as schemas
from intellwheels_schemas import present
from intellwheels_schemas.command_parser import CommandParser
from intellwheels_server import __main__ as server
from intellwheels_server import server_options
from intellwheels_server.service import lab_keys, router
from intellwheels_viewer import __main__ as viewer
from tests.commands import SCRIPTS

DEADLINE = 25.0
"""Seconds: five times what is promised."""

NUMBERS = ("", "x", "nan", "inf", "-inf", "1e400", "1,5", "-1e30", "1e30")
WHOLE = ("", "x", "nan", "1.5", "-1", "1e3", "9" * 30)
NAMES = ("", "No Name", "*", "@x", "a/b", "x" * 33)
DOCUMENTS = ("", "nosuch", "no/such.xml", "folder/", "text.xml")
ENDPOINTS = ("", "x", "127.0.0.1:7447", "http://127.0.0.1:7447", "tcp/127.0.0.1", "tcp/h:70000", "tcp:h:1")
INPUTS = ("", "none", "folder")
OUTPUTS = ("folder", "none/x", "text.xml/x")
FOLDERS = ("text.xml", "text.xml/x")
PLACES = ("", "a b", "x" * 65)
NO_NUMBERS = ("MotorNoise=007", "MotorNoise=1e999")
PAIRS = ("", "x", "=1", "nobody.x=1", "chair1.=1", "Nosuch=1", "nosuch=1")

WRONG: dict[str, Sequence[str]] = {
    "S": NUMBERS, "F": NUMBERS, "MB": NUMBERS, "M": NUMBERS, "P": NUMBERS, "R": NUMBERS, "K": NUMBERS, "SHARE": NUMBERS,
    "N": WHOLE, "TICK": WHOLE, "TICKS": WHOLE, "FD": WHOLE,
    "HEADER": ("", "a b", "x:"), "NAME": NAMES, "AGENT": NAMES, "A,B,C": NAMES[1:],
    "HOST[:PORT]": ("", "http://h", "a b", "h:0"), "HOST:PORT": ("", "h", "h:x", "h:99999", "a b:1"), "BUS": ("",),
    "V": NUMBERS, "X": (*WHOLE, "16"), "KEY=VALUE": ("", "x", "=1", "a b=1", "bitrate=1"),
    "NAME|FILE": DOCUMENTS, "SCENE": DOCUMENTS, "MAP": DOCUMENTS,
    "MIND": ("", "nosuch", "no/such.py", "folder/", "text.py"),
    "ENDPOINT": ENDPOINTS, "ADDRESS": ("", "http://x", "127.0.0.1:80", "no host", "192.0.2.1"),
    "DEVICE|URL": ("", "http://x"), "TEXT": ("x" * 65, "\x01"), "X,Y,DEG": ("", "1,2", "1,2,x", "nan,0,0", "0,0,361"),
    "FILE": INPUTS, "LOG": INPUTS, "PIPE": INPUTS, "FILE.svg": OUTPUTS, "FILE.html": OUTPUTS, "DIR": FOLDERS,
    "BAG": (*FOLDERS, "folder"),
    "FOLDER": FOLDERS, "PATH": ("text.xml", "none/x"), "PLACE": PLACES, "ROW": ("", "nosuch"),
    "AGENT=PLACE": ("", "x", "=start1", "chair1=", "No=start1", "chair1=a b"),
    "AGENT=COMMAND": ("", "x", "=./x", "nobody=./x", "chair1=", "chair1='", "chair1=./no/such {nmae}"),
    "AGENT=MIND": ("", "x", "=drive", "nobody=drive", "chair1="),
    "AGENT.NAME=VALUE": ("", "x", "=1", "nobody.x=1", "chair1.=1"),
    "I/N": ("", "x", "2", "0/2", "3/2", "1/0", "-1/2", "1/2/3"),
    "KEY,KEY": ("", "escape", "a,a", "a,b,c", "\x01"),
    "SIGNAL=KEY,...": ("", "x", "puff=a", "hard-puff=", "hard-puff=left"),
    "STREAM": ("", "\x01", "x" * 257, "'\""), "ON[,OFF]": ("", "x", "nan", "1,2", "1,"),
    "AXIS=CHANNEL,...": ("", "x", "up=1", "forward=", "forward=1*0", "turn=1,turn=2"),
    "COMMAND=CHANNEL,...": ("", "x", "up=1", "left=", "left=1*nan"), "HZ": (*WHOLE, "8000"), "mic|-|FILE.wav": INPUTS,
    "NAME=VALUE": (*PAIRS, *NO_NUMBERS), "FIELD=VALUE": (*PAIRS, *NO_NUMBERS, "MotorNoise=x"),
}  # fmt: skip
"""Wrong values of an option, by its metavar."""

OWN: dict[str, Sequence[str]] = {
    "iw-run --json": OUTPUTS, "iw-run --log": OUTPUTS,
    "iw-run --speed": (*NUMBERS, "5000"), "iw-server --speed": (*NUMBERS, "5000"),
    "iw-server --period": (*NUMBERS, "2"),
    "iw-record --port": (*WHOLE, "65536"), "iw-ciber --port": (*WHOLE, "65536"),
    "iw-viewer --allow-host": ("", "http://x", "a b", "a:x"), "iw-viewer --port": (*WHOLE, "65536"),
    "iw-run --view-port": (*WHOLE, "65536"), "python -m intellwheels_agents.bridge.firmware_stand_in --counts": NUMBERS,
    "iw list KIND": ("", "nosuch"), "python -m intellwheels_schemas check FILE": INPUTS,
    "iw-server --log": OUTPUTS, "iw-server --runs": FOLDERS, "iw-server --trace": OUTPUTS,
    "iw-viewer --record": OUTPUTS, "iw-run --merge": ("", "none", "folder", "text.xml", "/dev/null"),
}  # fmt: skip
"""Wrong values of one option of one command."""

WITH: dict[str, Sequence[str]] = {
    "iw-run --row": ("--seeds", "1"), "iw-run --jobs": ("--seeds", "1"), "iw-run --out": ("--seeds", "1"),
    "iw-run --part": ("--seeds", "1"), "iw-run --merge": ("--seeds", "1"),
    "iw-record --host": ("--live",), "iw-record --port": ("--live",), "iw-record --hold": ("--live",),
    "iw-record --take": ("--live",),
    "iw-server --trace": ("--resimulate", "/dev/null"), "iw-server --reported": ("--play", "/dev/null"),
    "iw-joystick --script": ("--source", "script"),
    **{
        f"iw-joystick --{name}": ("--source", "lsl", "--stream-name", "x")
        for name in ("stream-name", "stream-type", "axes", "commands")
    },
    "iw-joystick --threshold": ("--source", "lsl", "--stream-name", "x", "--commands", "stop=0"),
    "iw-joystick --dead-zone": ("--source", "lsl", "--stream-name", "x", "--axes", "turn=0"),
    "iw-joystick --dwell": ("--source", "scan", "--scan", "dwell"),
    "iw-joystick --scan-period": ("--source", "scan"), "iw-joystick --switch-keys": ("--source", "scan"),
    "iw-joystick --signals": ("--source", "sip-puff"),
    "iw-joystick --audio": ("--source", "voice"), "iw-joystick --audio-rate": ("--source", "voice", "--audio", "-"),
    "iw-ros --robot": ("--name", "c"), "iw-ros --option": ("--name", "c"), "iw-ros --place": ("--name", "c"),
}  # fmt: skip
"""What else an option needs to be looked at."""


DRIVER = {
    "iw-bridge --port": "serial", "iw-bridge --address": "luci", "iw-bridge --channel": "rnet",
    "iw-bridge --interface": "rnet --channel can0", "iw-bridge --can-option": "rnet --channel can0",
}  # fmt: skip
"""The driver with which an option of the bridge is looked at, and what the driver needs."""


@dataclass(frozen=True)
class Command:
    """A command and a usage of it that is right."""

    main: Callable[[list[str]], int]
    parser: Callable[[], argparse.ArgumentParser]
    before: Sequence[str] = ()
    after: Sequence[str] = ()


COMMANDS = {
    "iw-run": Command(run.main, run_parser.parser, ["figure6"]),
    "iw-server": Command(server.main, server_options.parser),
    "iw-record": Command(record.main, record.parser, ["run.mcap"]),
    "iw-agent": Command(agent.main, agent.parser, ["avoid"]),
    "iw-bridge": Command(bridge.main, bridge.parser, ["world", "--name", "chair1"]),
    "iw-joystick": Command(joystick.main, joystick_options.parser, ["chair1"]),
    "iw-viewer": Command(viewer.main, viewer.parser),
    "iw-ros": Command(ros.main, ros.parser),
    "iw-ciber": Command(ciber.main, ciber.parser),
    "iw-router": Command(router.main, router.parser),
    "iw-lab": Command(lab_keys.main, lab_keys.parser, ["keys"]),
    "iw-check-agent": Command(check_agent.main, check_agent.parser, [], ["--", "true"]),
    "python -m intellwheels_maps": Command(maps.main, maps._parser),
    "python -m intellwheels_schemas": Command(schemas.main, schemas._parser),
    "python -m intellwheels_schemas.present": Command(present.main, present.parser),
    firmware_stand_in.PROGRAM: Command(firmware_stand_in.main, firmware_stand_in.parser),
    luci_stand_in.PROGRAM: Command(luci_stand_in.main, luci_stand_in.parser),
    rnet_stand_in.PROGRAM: Command(rnet_stand_in.main, rnet_stand_in.parser, ["--channel", "can0"]),
}
"""Every command with options."""

POSITIONAL: list[tuple[str, Callable[[list[str]], int], list[str], str, Sequence[str]]] = [
    ("iw-run", run.main, [], "SCENE", DOCUMENTS),
    ("iw-agent", agent.main, [], "MIND", WRONG["MIND"]),
    ("iw-agent new", agent.main, ["new"], "DIR", FOLDERS),
    ("iw-joystick", joystick.main, ["--source", "words"], "AGENT", NAMES),
    ("iw-bridge", bridge.main, ["--name", "c"], "driver", ("", "nosuch")),
    ("iw-check-agent", check_agent.main, ["--"], "COMMAND", ("", "nosuch", "no/such", "text.xml")),
    ("iw-record", record.main, [], "FILE.mcap", OUTPUTS),
    ("iw list", iw, ["list"], "KIND", ("", "nosuch")),
    ("iw list", iw, ["list", "places"], "MAP", DOCUMENTS),
    ("iw completion", iw, ["completion"], "SHELL", ("", "nosuch")),
    ("python -m intellwheels_maps check", maps.main, ["check"], "FILE", INPUTS),
    ("python -m intellwheels_maps draw", maps.main, ["draw", "room"], "FILE.svg", OUTPUTS),
    ("python -m intellwheels_schemas", schemas.main, ["check"], "FILE", INPUTS),
]
"""Arguments without an option: the command, its first words, the argument, and wrong values."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with a folder and a text that is no document, and no place for anything else."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "text.xml").write_text("text")
    (tmp_path / "text.py").write_text("class Other:\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    over = threading.Event()
    over.set()
    for command in COMMANDS.values():
        module = sys.modules[command.main.__module__]
        if hasattr(module, "stop_on_signals"):
            # Signals are not what is tested, and each call would leave a thread behind.
            monkeypatch.setattr(module, "stop_on_signals", lambda *_: over)
    return tmp_path


def actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        if action.option_strings and not isinstance(action, (argparse._HelpAction, argparse._VersionAction)):
            yield action


def wrong_words(name: str, command: Command) -> Iterator[tuple[str, list[str]]]:
    """Yield each option of a command with each wrong value: the option, and the command line."""
    for action in actions(command.parser()):
        option = action.option_strings[0]
        own = f"{name} {option}"
        words = [*command.before, *WITH.get(own, ())]
        if option == "--name" and "--name" in words:
            words = ["world"]
        if action.nargs == 0 and not isinstance(action, argparse.BooleanOptionalAction):
            yield option, [*words, f"{option}=yes", *command.after]
            continue
        if isinstance(action, argparse.BooleanOptionalAction):
            continue
        if action.choices is not None:
            values: Sequence[str] = ("", "nosuch")
        elif own in OWN:
            values = OWN[own]
        else:
            assert isinstance(action.metavar, str), own
            assert action.metavar in WRONG, f"{own}: expected wrong values for {action.metavar} in WRONG"
            values = WRONG[action.metavar]
        if own in DRIVER:
            words = [*DRIVER[own].split(), "--name", "chair1"]
        for value in values:
            yield option, [*words, f"{option}={value}", *command.after]
        yield option, [*words, option]


def fault(
    main: Callable[[list[str]], int], words: list[str], option: str, capsys: pytest.CaptureFixture[str]
) -> str | None:
    """Return what is wrong with the end of a wrong usage, or None."""
    try:
        code: object = main(words)
    except SystemExit as ended:
        code = ended.code
    printed = capsys.readouterr()
    line = printed.err
    if code != 2:
        return f"exit code {code}: {line}"
    if printed.out or line.count("\n") != 1 or not line.endswith("\n"):
        return f"printed {printed.out + line!r}"
    missing = [word for word in (option.lstrip("-"), "expected ", ", got ") if word not in line]
    return f"{missing} not in {line!r}" if missing else None


def tree(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if "__pycache__" not in path.parts)


def faults_of(
    usages: Iterator[tuple[str, list[str]]],
    main: Callable[[list[str]], int],
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> list[str]:
    before, found = tree(folder), []
    for option, words in usages:
        wrong = fault(main, words, option, capsys)
        if wrong is not None:
            found.append(f"{words}: {wrong}")
    if tree(folder) != before:
        found.append(f"left behind: {set(tree(folder)) - set(before)}")
    return found


@pytest.mark.parametrize("name", COMMANDS)
def test_wrong_values_of_every_option_are_one_line_each(
    name: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = COMMANDS[name]
    assert faults_of(wrong_words(name, command), command.main, folder, capsys) == []


@pytest.mark.parametrize(("name", "main", "first", "argument", "values"), POSITIONAL)
def test_wrong_arguments_are_one_line_each(
    name: str, main: Callable[[list[str]], int], first: list[str], argument: str, values: Sequence[str],
    folder: Path, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    usages = ((argument, [*first, value]) for value in values)
    assert faults_of(usages, main, folder, capsys) == []


def test_there_are_300_of_them_and_no_command_is_left_out() -> None:
    made = sum(1 for name, command in COMMANDS.items() for _ in wrong_words(name, command))
    assert made + sum(len(values) for *_, values in POSITIONAL) >= 300
    # `iw` has no options of its own.
    assert set(SCRIPTS) - COMMANDS.keys() == {"iw"}


def test_every_parser_is_of_our_kind() -> None:
    assert [name for name, command in COMMANDS.items() if not isinstance(command.parser(), CommandParser)] == []


SAMPLE = (
    ("iw-run", "figure6", "--json=none/x", "--json"),
    ("iw-server", "--map=nosuch", "--map"),
    ("iw-agent", "avoid", "--option=nosuch=1", "nosuch"),
    ("iw-bridge", "world", "--name=c", "--lab-connect=h:1", "--lab-connect"),
    ("iw-joystick", "chair1", "--source=script", "--script=none", "--script"),
    ("iw-record", "none/x.mcap", "FILE.mcap"),
    ("iw-viewer", "--host=192.0.2.1", "--host"),
    ("iw-router", "--listen=x", "--listen"),
    ("iw-ros", "--ros-connect=x", "--ros-connect"),
    ("iw-ciber", "--host=192.0.2.1", "--host"),
    ("iw-check-agent", "--connect=x", "--", "true", "--connect"),
    ("iw", "list", "places", "nosuch", "MAP"),
)
"""Usages and the option that the line must name, run as real processes."""


@pytest.mark.process
def test_real_commands_end_by_themselves_with_one_line(folder: Path) -> None:
    before = tree(folder)
    # One after the other: ten at once would need many times the time of one on a busy machine.
    for name, *words, option in SAMPLE:
        module, _, function = SCRIPTS[name].partition(":")
        program = f"import sys; from {module} import {function}; sys.exit({function}())"
        done = subprocess.run(
            [sys.executable, "-c", program, *words], capture_output=True, text=True, timeout=DEADLINE, check=False
        )
        err = done.stderr
        assert (done.returncode, done.stdout, err.count("\n")) == (2, "", 1), f"{name} {words}: {err}"
        assert option in err
        assert "expected " in err
        assert ", got " in err
    assert tree(folder) == before


def test_every_command_can_be_imported_for_its_options() -> None:
    for entry in SCRIPTS.values():
        import_module(entry.partition(":")[0])


WIDEST = 20_000.0
"""A range up to more than this is no limit that a user meets, and the help need not show it."""


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_the_range_of_every_number(name: str) -> None:
    lacking = []
    for action in COMMANDS[name].parser()._actions:
        if action.type is None or isinstance(action.type, (str, argparse.FileType)):
            continue
        try:
            action.type("no number")
        except argparse.ArgumentTypeError as error:
            found = re.search(r"in ([\[(][\d.]+, ([\d.]+)[\])])", str(error))
            if found is not None and float(found[2]) <= WIDEST and found[1] not in (action.help or ""):
                lacking.append(f"{action.option_strings}: {found[1]}")
        except (ValueError, OSError):
            continue
    assert lacking == []
