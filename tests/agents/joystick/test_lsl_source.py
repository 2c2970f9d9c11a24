"""A stream as a source, with real outlets in this process: found, read, stale, lost, and back."""

from __future__ import annotations

import re
import sys
import threading
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from intellwheels_agents.joystick import lsl_source
from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.lsl_channels import ChannelError, ChannelMap, parse_uses
from intellwheels_agents.joystick.lsl_source import LslSource, stream_text
from intellwheels_agents.joystick.pygame_source import DeviceError
from tests.agents.joystick import streams

DEADLINE = 20.0
AXES = ChannelMap(axes=parse_uses("forward=0,turn=1", "--axes"))


def until(source: LslSource, found: Callable[[InputState], bool], tell: Callable[[], object] = lambda: None) -> None:
    """Run the source until its state is so, with something done before each look."""
    deadline = time.monotonic() + DEADLINE
    while True:
        tell()
        source.wait(0.02)
        state = source.state(time.monotonic(), None)
        if state is not None and found(state):
            return
        assert time.monotonic() < deadline, state


@pytest.mark.process
def test_a_stream_drives_until_it_is_stale_or_lost_and_again_when_it_is_back(
    capfd: pytest.CaptureFixture[str],
) -> None:
    out: list[Any] = [streams.outlet("back")]
    source = LslSource("back", "EEG", AXES, threading.Event())
    until(source, lambda state: state == InputState(1.0, -0.5), lambda: out[0].push_sample([1.0, -0.56]))
    state = source.state(time.monotonic(), None)
    assert state is not None
    assert state.at is not None
    assert -0.01 <= time.monotonic() - state.at < 0.3
    # Nothing comes: stale. What is not finite does not make it fresh.
    until(source, lambda state: state.is_neutral)
    out[0].push_sample([float("nan"), 0.0])
    until(source, lambda _: "expected a finite number, got 'nan'" in source._told)
    assert source.state(time.monotonic(), None) == NEUTRAL
    until(source, lambda state: state == InputState(1.0), lambda: out[0].push_sample([1.0, 0.0]))
    out.clear()
    until(source, lambda _: source._inlet is None)
    assert source.state(time.monotonic(), None) == NEUTRAL
    out.append(streams.outlet("back"))
    until(source, lambda state: state == InputState(-1.0), lambda: out[0].push_sample([-1.0, 0.0]))
    told = [line.rpartition(": ")[2] for line in capfd.readouterr().err.splitlines() if "iw-joystick" in line]
    assert [line for line in told if line in ("stale", "fresh", "lost")][:4] == ["fresh", "stale", "fresh", "lost"]
    # Another stream of that name, with too few channels, ends it with a reason.
    out.clear()
    until(source, lambda _: source._inlet is None)
    out.append(streams.outlet("back", channels=1))
    with pytest.raises(ChannelError, match=r"--axes: expected a channel in \[0, 0\], got turn=1"):
        until(source, lambda _: False)


def announced(name: str, kind: str, uid: str) -> Any:
    """Return what the resolver tells about a stream."""
    texts = {"name": name, "type": kind, "uid": uid}
    numbers = {"channel_count": 2, "nominal_srate": 0.0, "channel_format": 1}
    return SimpleNamespace(**{key: lambda value=value: value for key, value in {**texts, **numbers}.items()})


class LostError(Exception):
    """What pylsl raises when a stream is lost."""


class Library:
    """Stands in for pylsl: its resolver lists what the test says, and its inlets are empty."""

    cf_string, proc_clocksync = 3, 1
    util = SimpleNamespace(LostError=LostError, TimeoutError=TimeoutError)

    def __init__(self, *here: Any) -> None:
        self.here = list(here)
        self.is_lost = False

    def ContinuousResolver(self, **_: Any) -> Any:  # noqa: N802 - as pylsl has it
        return SimpleNamespace(results=lambda: self.here)

    def StreamInlet(self, info: Any, **_: Any) -> Any:  # noqa: N802 - as pylsl has it
        return SimpleNamespace(pull_chunk=self.pull, info=info)

    def pull(self, **_: Any) -> tuple[list[Any], list[float]]:
        if self.is_lost:
            raise LostError
        return [], []

    def resolve_streams(self, **_: Any) -> list[Any]:
        return self.here

    def local_clock(self) -> float:
        return time.monotonic()


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Library:
    made = Library(announced("mine", "EEG", "1"))
    monkeypatch.setattr(lsl_source, "pylsl_of", lambda: made)
    monkeypatch.setattr(lsl_source, "OTHERS_SECONDS", 0.0)
    return made


def lose(source: LslSource, library: Library, *, seconds_ago: float) -> None:
    library.is_lost = True
    source.wait(0.0)
    library.is_lost = False
    assert source._inlet is None
    source._lost_at -= seconds_ago


def test_the_same_stream_is_taken_again_after_the_network_was_cut(library: Library) -> None:
    source = LslSource(None, "EEG", AXES, threading.Event())
    lose(source, library, seconds_ago=1.0)
    source.wait(0.0)
    assert source._inlet is None  # it may be what is still listed
    source._lost_at -= 1.0
    source.wait(0.0)
    assert source._inlet is not None


def test_no_other_stream_takes_over_from_a_lost_one(library: Library, capsys: pytest.CaptureFixture[str]) -> None:
    source = LslSource(None, "EEG", AXES, threading.Event())
    lose(source, library, seconds_ago=2.0)
    library.here = [announced("of somebody else", "EEG", "2")]
    source.wait(0.0)
    assert source._inlet is None
    library.here = [announced("mine", "EEG", "3"), announced("mine", "EEG", "4")]
    source.wait(0.0)
    assert source._inlet is None
    assert "expected one stream, got 'mine' (EEG, 2 channels, irregular); 'mine'" in capsys.readouterr().err
    del library.here[0]
    source.wait(0.0)
    assert source._uid == "4"


def test_a_signal_while_a_stream_is_looked_for_is_no_error(library: Library) -> None:
    stop = threading.Event()
    stop.set()
    for here in ([], library.here * 2):
        library.here = here
        assert LslSource(None, "EEG", AXES, stop).state(0.0, None) == NEUTRAL


def test_the_texts_of_a_stream_cannot_write_to_the_terminal(library: Library) -> None:
    library.here = [announced("\x1b[2J", "\x1b[2J", "1"), announced("a", "x" * 10_000, "2")]
    with pytest.raises(DeviceError) as refused:
        LslSource(None, "EEG", AXES, threading.Event())
    assert str(refused.value).isprintable()
    assert len(str(refused.value)) < 1000


@pytest.mark.process
def test_labels_and_texts_of_a_stream() -> None:
    labelled = streams.outlet("labelled", labels=("Fz", "Cz"))
    source = LslSource("labelled", None, ChannelMap(axes=parse_uses("forward=Cz", "--axes")), threading.Event())
    until(source, lambda state: state == InputState(1.0), lambda: labelled.push_sample([0.0, 1.0]))
    words = streams.outlet("markers", "Markers", 1, text=True)
    source = LslSource(None, "Markers", ChannelMap(forward=0.5), threading.Event())
    until(source, lambda state: state == InputState(-0.5, word="back"), lambda: words.push_sample(["reverse"]))


@pytest.mark.process
def test_an_unknown_or_ambiguous_stream_is_refused_with_those_that_are_there(monkeypatch: pytest.MonkeyPatch) -> None:
    here = [streams.outlet("twin", "EMG"), streams.outlet("twin", "gaze")]

    def refused(name: str, listed: str) -> bool:
        # On a busy machine streams take longer to answer than a user wants to wait.
        for seconds in (0.5, 3.0, DEADLINE):
            monkeypatch.setattr(lsl_source, "LIST_SECONDS", seconds)
            monkeypatch.setattr(lsl_source, "OTHERS_SECONDS", seconds)
            try:
                LslSource(name, None, AXES, threading.Event(), find=0.1 if name == "none" else DEADLINE)
            except DeviceError as error:
                if re.search(listed, str(error)):
                    return True
        return False

    assert refused("none", r"expected a stream with name 'none', got 'twin' \(\w+, 2 channels, irreg")
    assert refused("twin", r"expected one stream with name 'twin', got .*; give --stream-name and")
    assert len(here) == 2


@pytest.mark.parametrize("text", ["", "x" * 257, "a\nb", "'\""])
def test_a_name_that_cannot_be_looked_for_is_refused(text: str) -> None:
    with pytest.raises(ChannelError, match="expected a printable text of 1 to 256 characters"):
        stream_text(text)
    assert stream_text("Muse's EEG") == "Muse's EEG"


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(DeviceError, match=r"pip install '\.\[lsl\]'"):
        LslSource("x", None, AXES, threading.Event())
