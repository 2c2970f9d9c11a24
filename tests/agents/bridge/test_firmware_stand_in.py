from __future__ import annotations

import random

import pytest

from intellwheels_agents.bridge.firmware_stand_in import TURN, WATCHDOG, Bench, Controller, Terminal
from intellwheels_agents.bridge.line_protocol import PowerLine, Splitter, Telemetry, read, written

GO = written(PowerLine(500, 500))


def telemetry(data: bytes) -> list[Telemetry]:
    return [one for line in Splitter().feed(data) if isinstance(one := read(line), Telemetry)]


def test_it_obeys_and_counts() -> None:
    controller = Controller(3, 2, 1000.0)
    out = b"".join(controller.turn(TURN, GO if i % 10 == 0 else b"") for i in range(400))
    told = telemetry(out)
    assert controller.told == [f"moving ms={round(1000 * TURN)}"]
    assert [one.seq for one in told] == list(range(1, len(told) + 1))
    assert 95 <= len(told) <= 101
    # Half power for 2 s, less the lag.
    assert told[-1].left == pytest.approx(1000 * 0.5 * (2.0 - 0.1), abs=10)
    assert told[-1].ranges == ("n", "n")


@pytest.mark.parametrize("noise", [False, True])
def test_its_watchdog_stops_it_within_two_tenths_of_the_last_valid_power(noise: bool) -> None:
    controller, rng = Controller(1, 0, 1000.0), random.Random(1)
    controller.turn(TURN, GO)
    began = controller.clock
    while controller.power != (0, 0) and controller.clock < began + 1.0:
        controller.turn(TURN, rng.randbytes(30) if noise else b"")
    assert 0.15 < controller.clock - began <= WATCHDOG + 1e-9
    assert controller.told[-1].startswith("stopped ms=")
    # No greeting, no restart: the next valid power is obeyed. Garbage may have begun a line.
    controller.turn(TURN, b"\n" + GO)
    assert controller.power == (500, 500)


def test_it_stands_when_it_is_told_to() -> None:
    controller = Controller(1, 0, 1000.0)
    controller.turn(TURN, GO)
    controller.turn(TURN, written(PowerLine(0, 0)))
    assert controller.told[-1] == f"stopped ms={round(2000 * TURN)} silence=-1"


def test_a_cut_line_passes_nothing_either_way() -> None:
    terminal = Terminal(None)
    try:
        bench = Bench(terminal, 0, 1000.0)
        sent: list[bytes] = []
        terminal.write = sent.append  # type: ignore[method-assign, assignment]
        terminal.read = lambda: GO  # type: ignore[method-assign]
        bench.ask("cut 1")
        for _ in range(20):
            bench.turn(0.02)
        assert (sent, bench.controller.power) == ([], (0, 0))
        for _ in range(40):
            bench.turn(0.02)
        assert sent
        assert bench.controller.power == (500, 500)
    finally:
        terminal.unplug()


def test_a_new_boot_is_another_era(capsys: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal(None)
    try:
        bench = Bench(terminal, 0, 1000.0)
        bench.ask("boot")
        assert telemetry(bench.controller.turn(0.02, b""))[0].boot == 2
        bench.ask("dance")
        assert "expected cut, noise" in capsys.readouterr().err
    finally:
        terminal.unplug()
