"""Samples of a stream as input, without a stream."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.lsl_channels import (
    ChannelError,
    ChannelMap,
    ChannelUse,
    StreamInput,
    parse_threshold,
    parse_uses,
)
from tests.every_case import every_case

AXES = parse_uses("forward=0,turn=1*-0.5", "--axes")
COMMANDS = parse_uses("forward=0,left=1,stop=2", "--commands")


def stream(count: int = 3, *, labels: tuple[str, ...] = (), is_text: bool = False, **settings: Any) -> StreamInput:
    return StreamInput(ChannelMap(**settings), count, labels, is_text=is_text)


def state(made: StreamInput, *values: object, now: float = 10.0) -> InputState:
    made.add(values, now, now)
    return made.state(now)


def test_axes_have_a_factor_a_dead_zone_and_the_shares() -> None:
    made = stream(axes=AXES, forward=0.5, turn=0.4, dead_zone=0.1)
    assert state(made, 1.0, 0.0, 9.0) == InputState(0.5)
    assert state(made, -0.55, 0.0, 0.0) == InputState(-0.25)
    assert state(made, 0.0, 1.1, 0.0) == InputState(0.0, -0.4 * 0.5)
    assert state(made, 0.1, -0.2, 0.0) == NEUTRAL
    assert state(made, 1e300, -1e300, 0.0) == InputState(0.5, 0.4)


def test_commands_have_a_threshold_below_which_they_end_and_stop_is_first() -> None:
    made = stream(commands=COMMANDS, on=0.5, off=0.3, forward=0.5, turn=0.4)
    assert state(made, 0.49, 0.0, 0.0) == NEUTRAL
    assert state(made, 0.5, 0.0, 0.0) == state(made, 0.3, 0.0, 0.0) == InputState(0.5)
    assert state(made, 0.4, 0.6, 0.0) == InputState(0.5, 0.4)
    assert state(made, 0.4, 0.6, 0.5) == NEUTRAL
    assert state(made, 0.29, 0.2, 0.2) == NEUTRAL


def test_commands_go_before_axes() -> None:
    made = stream(axes=AXES, commands=parse_uses("stop=2", "--commands"))
    assert state(made, 1.0, 0.0, 0.0) == InputState(1.0)
    assert state(made, 1.0, 0.0, 1.0) == NEUTRAL


def test_labels_name_channels() -> None:
    made = stream(axes=parse_uses("forward=Cz", "--axes"), labels=("Fz", "Cz", "Pz"))
    assert state(made, 0.0, 1.0, 0.0) == InputState(1.0)
    with pytest.raises(ChannelError, match=r"--axes: expected a number or a label .* \('Fz', 'Cz'\), got 'cz'"):
        stream(axes=parse_uses("forward=cz", "--axes"), labels=("Fz", "Cz"))
    with pytest.raises(
        ChannelError, match="--axes: expected a label of one channel, got 'Cz' of 2; give the channel's"
    ):
        stream(axes=parse_uses("forward=Cz", "--axes"), labels=("Cz", "Fz", "Cz"))
    # What only looks like a number is looked for among the labels.
    for label in ("²", "1234567890"):
        made = stream(axes=parse_uses(f"forward={label}", "--axes"), labels=("Fz", label))
        assert state(made, 0.0, 1.0, 0.0) == InputState(1.0)


@pytest.mark.parametrize(
    ("word", "forward", "turn"), [("forward", 0.5, 0.0), (" Reverse\n", -0.5, 0.0), ("left", 0, 0.4)]
)
def test_a_stream_of_texts_has_words(word: str, forward: float, turn: float) -> None:
    got = state(stream(is_text=True, forward=0.5, turn=0.4), word, "", "")
    assert (got.forward, got.turn) == (forward, turn)
    assert state(stream(is_text=True), "<script>", "", "") == NEUTRAL


def test_a_word_whose_share_is_0_drives_nothing_by_itself_either() -> None:
    made = stream(is_text=True, forward=0.0, turn=0.4)
    assert state(made, "forward", "", "") == NEUTRAL
    assert state(made, "left", "", "") == InputState(0.0, 0.4, word="left")
    assert state(made, "stop", "", "") == InputState(word="stop")


def test_input_is_zero_when_the_newest_sample_is_older_than_0_3_s() -> None:
    made = stream(axes=AXES)
    made.add((1.0, 0.0, 0.0), 9.9, 10.0)
    assert made.state(10.0) == InputState(1.0)
    assert made.state(10.0).at == 9.9
    assert made.state(10.19) == InputState(1.0)
    assert made.state(10.21) == NEUTRAL
    assert made.is_stale(10.21)


def test_a_stale_command_is_off_until_its_threshold_is_reached_again() -> None:
    made = stream(commands=COMMANDS, on=0.5, off=0.3)
    state(made, 0.6, 0.0, 0.0)
    assert made.state(11.0) == NEUTRAL
    assert state(made, 0.4, 0.0, 0.0, now=11.1) == NEUTRAL


def test_late_samples_are_dropped_and_stamps_of_the_future_are_now() -> None:
    made = stream(axes=AXES)
    made.add((1.0, 0.0, 0.0), 5.0, 10.0)
    assert made.state(10.0) == NEUTRAL
    assert made.problem == "expected samples of the last 0.3 s, got one of 5.0 s ago"
    for stamp in (1e9, math.nan, math.inf):
        made.add((1.0, 0.0, 0.0), stamp, 10.0)
        assert made.state(10.2) == InputState(1.0)
        assert made.state(10.31) == NEUTRAL


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, "1.0x", None, 10**400])
def test_a_sample_that_is_no_number_is_dropped_and_the_one_before_ages(value: object) -> None:
    made = stream(axes=AXES)
    made.add((1.0, 0.0, 0.0), 10.0, 10.0)
    made.add((value, 0.0, 0.0), 10.1, 10.1)
    assert made.dropped == 1
    assert "channel 0: expected a finite number, got" in made.problem
    assert made.state(10.2) == InputState(1.0)
    assert made.state(10.31) == NEUTRAL
    # What is not used may be anything.
    assert state(made, 1.0, 0.0, value) == InputState(1.0)


@pytest.mark.parametrize("values", [(), (1.0,), (1.0, 0.0, 0.0, 0.0)])
def test_a_sample_with_another_number_of_channels_is_dropped(values: tuple[float, ...]) -> None:
    made = stream(axes=AXES)
    made.add(values, 10.0, 10.0)
    assert made.state(10.0) == NEUTRAL
    assert made.problem == f"expected 3 channels, got {len(values)}"


def test_a_lost_stream_is_stale_at_once() -> None:
    made = stream(axes=AXES)
    state(made, 1.0, 0.0, 0.0)
    made.lost()
    assert made.state(10.0) == NEUTRAL


def test_a_channel_that_the_stream_lacks_and_a_stream_of_the_other_kind_are_refused() -> None:
    with pytest.raises(ChannelError, match=r"--axes: expected a channel in \[0, 0\], got turn=1"):
        stream(1, axes=AXES)
    with pytest.raises(ChannelError, match="--commands: expected a channel"):
        stream(2, commands=COMMANDS)
    with pytest.raises(ChannelError, match="expected none for a stream of texts"):
        stream(axes=AXES, is_text=True)
    with pytest.raises(ChannelError, match="expected at least one for a stream of numbers, got none"):
        stream()


@every_case(
    "text",
    ["", "forward", "forward=", "=0", "up=0", "forward=0,forward=1", "forward=0*", "forward=0*x", "forward=0*nan",
     "forward=0*0", "forward=0,,turn=1"],
)  # fmt: skip
def test_wrong_uses_are_refused(text: str) -> None:
    with pytest.raises(ChannelError, match="--axes: expected each of forward, turn at most once"):
        parse_uses(text, "--axes")


def test_uses_and_thresholds_are_read() -> None:
    assert parse_uses("left=EMG 1*2, stop=7", "--commands") == (
        ChannelUse("left", "EMG 1", 2.0), ChannelUse("stop", "7"),
    )  # fmt: skip
    assert parse_threshold("0.5") == (0.5, 0.5)
    assert parse_threshold("3,-1") == (3.0, -1.0)
    for text in ("", "x", "nan", "0.5,0.6", "1,", "1,2,3"):
        with pytest.raises(ChannelError, match="--threshold: expected a number ON"):
            parse_threshold(text)
