"""Streams, switches and words move the motors of a simulated chair, and their silence stops them. Real processes.

The motors obey at once (`AccelerationCurve=0`).
"""

from __future__ import annotations

import os
import re
import signal
import sys
import wave
from collections.abc import Callable
from typing import Any

import pytest

from intellwheels_schemas.extras import missing_extra
from tests.agents.joystick import spoken, streams
from tests.e2e.stage import Peer, Stage

AT_ONCE = ("--option", "AccelerationCurve=0")
FORWARD = 0.4


def outputs(peer: Peer, like: Callable[[float, float], bool], tell: Callable[[], object] = lambda: None) -> None:
    """Wait until the motor outputs of the chair are so, with something done before each look."""

    def found(entity: dict[str, Any]) -> bool:
        tell()
        return like(entity.get("LeftOutput", 0.0), entity.get("RightOutput", 0.0))

    peer.entity("chair1", found)


def forward(left: float, right: float) -> bool:
    return left == right == pytest.approx(FORWARD)


def turning_left(left: float, right: float) -> bool:
    return left < 0.0 < right


def still(left: float, right: float) -> bool:
    return left == right == 0.0


def command(stage: Stage, *words: str) -> list[str]:
    return [
        sys.executable, "-m", "intellwheels_agents.joystick", "chair1", "--forward", str(FORWARD), "--latency",
        "--connect", stage.endpoint, "--world", stage.world, *words,
    ]  # fmt: skip


def latency(stage: Stage, child: str) -> dict[str, float]:
    """Return what the command printed about latency at its end."""
    line = stage.find_line(child, "latency", agent="chair1")
    assert line is not None
    return {name: float(value) for name, value in line.items() if name != "agent"}


@pytest.fixture
def chair(stage: Stage) -> Stage:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("chair1", "joystick", *AT_ONCE)
    return stage


def test_a_stream_moves_the_motors_until_it_is_silent_or_gone_and_again_when_it_is_back(chair: Stage) -> None:
    out = [streams.outlet("bci")]
    words = command(chair, "--source", "lsl", "--stream-name", "bci", "--axes", "forward=0,turn=1")
    child = chair.launch("joystick", lambda fd: [*words, "--lifeline", str(fd)])
    chair.line(child, "ready", agent="chair1")
    with chair.peer() as peer:
        outputs(peer, forward, lambda: out[0].push_sample([1.0, 0.0]))
        outputs(peer, still)
        outputs(peer, turning_left, lambda: out[0].push_sample([0.0, 1.0]))
        out.clear()
        outputs(peer, still)
        out.append(streams.outlet("bci"))
        outputs(peer, forward, lambda: out[0].push_sample([1.0, 0.0]))
    chair.signal(child, signal.SIGTERM)
    assert chair.exit(child) == 0
    measured = latency(chair, child)
    assert measured["starts"] >= 2
    assert 0.0 <= measured["put_median"] <= measured["start_median"]


def test_switches_and_a_sip_and_puff_in_a_terminal_move_the_motors(chair: Stage) -> None:
    ours, theirs = os.openpty()
    terminal = os.ttyname(theirs)
    try:
        with chair.peer() as peer:
            for source, words, keys in (
                ("scan", ["--scan", "step", "--switch-keys", "a,b"], (b"b", b"a", b"b")),
                ("sip-puff", ["--signals", "hard-puff=b,soft-sip=a"], (b"b", b"", b"a")),
            ):
                line = command(chair, "--source", source, "--keys-from", "terminal", "--turn", "0.5", *words)
                child = chair.launch(
                    source,
                    lambda fd, line=line: ["sh", "-c", 'exec "$@" < "$0"', terminal, *line, "--lifeline", str(fd)],  # type: ignore[misc]
                )
                chair.line(child, "ready", agent="chair1")
                outputs(peer, forward, lambda keys=keys: os.write(ours, keys[0]))  # type: ignore[misc]
                # The key is no longer repeated.
                outputs(peer, still)
                os.write(ours, keys[1])
                outputs(peer, turning_left, lambda keys=keys: os.write(ours, keys[2]))  # type: ignore[misc]
                outputs(peer, still)
                os.write(ours, b"\x04")
                assert chair.exit(child) == 0
                assert latency(chair, child)["starts"] >= 1
    finally:
        os.close(ours)
        os.close(theirs)


@pytest.mark.skipif(missing_extra("voice") is not None, reason=str(missing_extra("voice")))
def test_spoken_words_move_the_motors_and_stop_them(chair: Stage) -> None:
    file = chair.folder / "said.wav"
    with wave.open(str(file), "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(spoken.RATE)
        sound.writeframes(spoken.said("forward") + spoken.said("left") + spoken.said("stop"))
    with chair.peer() as peer:
        heard = peer.hear("state/*")
        line = command(chair, "--source", "voice", "--audio", str(file), "--hold", "5")
        child = chair.launch("joystick", lambda fd: [*line, "--lifeline", str(fd)])
        outputs(peer, forward)
        outputs(peer, turning_left)
        outputs(peer, still)
        assert chair.exit(child) == 0
    assert heard
    assert re.findall(r"heard word=(\w+)", chair.log(child)) == ["forward", "left", "stop"]
    measured = latency(chair, child)
    assert measured["starts"] == 1
    # The silence that ends a word is part of it.
    assert measured["start_median"] > 0.2
