from __future__ import annotations

import pytest

from intellwheels_agents.bridge.rnet_frames import Battery, Frame, Heartbeat, SpeedLimit, decode_frame, joystick_frame
from intellwheels_agents.bridge.rnet_stand_in import RnetChair, main
from intellwheels_schemas.errors import WireError


def steps(chair: RnetChair, count: int, *received: Frame) -> list[Frame]:
    frames = []
    for _ in range(count):
        for frame in received:
            chair.receive(frame)
        frames += chair.step(0.01)
    return frames


def test_it_sends_its_frames_at_their_periods() -> None:
    frames = steps(RnetChair(2, 1.0), 300)
    contents = [decode_frame(frame) for frame in frames]
    assert 299 <= frames.count(joystick_frame(2, 0.0, 0.0)) <= 301
    assert 29 <= sum(isinstance(one, Heartbeat) for one in contents) <= 31
    assert contents.count(Battery(87)) == contents.count(SpeedLimit(1.0)) == 3


def test_it_obeys_the_frames_of_whoever_sends_them_at_the_chosen_speed() -> None:
    chair = RnetChair(1, 1.0)
    chair.command("speed 50")
    steps(chair, 20, joystick_frame(1, 0.8, -0.2), joystick_frame(2, 1.0, 1.0))
    assert chair.chair.stick == (0.4, -0.1)
    assert chair.foreign == 40
    steps(chair, 10)
    assert chair.chair.stick == (0.0, 0.0)


def test_its_own_frames_that_come_back_are_not_foreign() -> None:
    chair = RnetChair(1, 1.0)
    for frame in steps(chair, 20):
        chair.receive(frame)
    chair.command("count")
    assert chair.chair.take_messages()[-1] == "foreign frames=0"


def test_its_user_steers_and_its_joystick_module_may_fall_silent() -> None:
    chair = RnetChair(1, 1.0)
    chair.command("stick 60 -20")
    steps(chair, 10)
    assert chair.chair.stick == (0.6, -0.2)
    chair.command("silence 1")
    assert not [one for one in steps(chair, 90) if one.identifier == 0x02000100]
    assert chair.chair.stick == (0.0, 0.0)  # by the watchdog
    assert "silence=2" in chair.chair.take_messages()[-1]


def test_garbage_is_none_of_the_known_frames() -> None:
    chair = RnetChair(1, 1.0)
    steps(chair, 1)
    chair.command("silence 9")
    chair.command("garbage 0.5")
    frames = steps(chair, 50)
    assert len(frames) == 50
    for frame in frames:
        with pytest.raises(WireError):
            decode_frame(frame)


@pytest.mark.parametrize("line", ["", "jump", "stick 1", "silence x"])
def test_other_commands_are_refused(line: str) -> None:
    with pytest.raises(ValueError, match=r".*"):
        RnetChair(1, 1.0).command(line)


def test_a_bus_must_be_given(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([])
    assert ended.value.code == 2
    assert "--channel: expected a CAN bus such as can0, got none" in capsys.readouterr().err
