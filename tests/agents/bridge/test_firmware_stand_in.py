from __future__ import annotations

import random

import pytest

from intellwheels_agents.bridge.firmware_stand_in import STEP, Controller, FaultyController, Terminal
from intellwheels_agents.bridge.line_protocol import LineSplitter, PowerLine, Telemetry, decode_line, encode_line
from intellwheels_agents.bridge.timeouts import CONTROLLER_WATCHDOG

GO = encode_line(PowerLine(500, 500))


def telemetry(data: bytes) -> list[Telemetry]:
    return [one for line in LineSplitter().feed(data) if isinstance(one := decode_line(line), Telemetry)]


def test_it_obeys_powers_and_counts_wheel_turns() -> None:
    controller = Controller(3, 2, 1000.0)
    out = b"".join(controller.step(STEP, GO if i % 10 == 0 else b"") for i in range(400))
    told = telemetry(out)
    assert controller.messages == [f"powered ms={round(1000 * STEP)}", f"moving ms={round(1000 * STEP)}"]
    assert [one.seq for one in told] == list(range(1, len(told) + 1))
    assert 95 <= len(told) <= 101
    # Half power for 2 s, less the lag.
    assert told[-1].left == pytest.approx(1000 * 0.5 * (2.0 - 0.1), abs=10)
    assert told[-1].ranges == ("n", "n")


@pytest.mark.parametrize("noise", [False, True])
def test_the_watchdog_stops_the_motors_0_2_s_after_the_last_valid_power(noise: bool) -> None:
    controller, rng = Controller(1, 0, 1000.0), random.Random(1)
    controller.step(STEP, GO)
    began = controller.clock
    while controller.power != (0, 0) and controller.clock < began + 1.0:
        controller.step(STEP, rng.randbytes(30) if noise else b"")
    assert 0.15 < controller.clock - began <= CONTROLLER_WATCHDOG + 1e-9
    assert controller.messages[-1].startswith("stopped ms=")
    # No greeting, no restart: the next valid power is obeyed. Garbage may have begun a line.
    controller.step(STEP, b"\n" + GO)
    assert controller.power == (500, 500)


def test_a_zero_power_stops_the_motors() -> None:
    controller = Controller(1, 0, 1000.0)
    controller.step(STEP, GO)
    controller.step(STEP, encode_line(PowerLine(0, 0)))
    assert controller.messages[-1] == f"stopped ms={round(2000 * STEP)} silence=-1"


def test_a_cut_line_passes_nothing_in_either_direction() -> None:
    terminal = Terminal(None)
    try:
        bench = FaultyController(terminal, 0, 1000.0)
        sent: list[bytes] = []
        terminal.write = sent.append  # type: ignore[method-assign, assignment]
        terminal.read = lambda: GO  # type: ignore[method-assign]
        bench.command("cut 1")
        for _ in range(20):
            bench.step(0.02)
        assert (sent, bench.controller.power) == ([], (0, 0))
        for _ in range(40):
            bench.step(0.02)
        assert sent
        assert bench.controller.power == (500, 500)
    finally:
        terminal.unplug()


def test_a_restart_gives_another_boot_number(capsys: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal(None)
    try:
        bench = FaultyController(terminal, 0, 1000.0)
        bench.command("boot")
        assert telemetry(bench.controller.step(0.02, b""))[0].boot == 2
        bench.command("dance")
        assert "expected cut, noise" in capsys.readouterr().err
    finally:
        terminal.unplug()


def test_its_counters_wrap_as_the_protocol_states() -> None:
    controller = Controller(1, 0, 1000.0, wrap_in=1.0)
    out = telemetry(b"".join(controller.step(STEP, GO) for _ in range(400)))
    for name, before, after in (
        ("seq", 2**32 - 60, 60),
        ("ms", 2**32 - 1100, 1100),
        ("left", 2**31 - 300, -(2**31) + 800),
    ):
        values = [getattr(one, name) for one in out]
        assert values[0] > before
        assert values[-1] < after
