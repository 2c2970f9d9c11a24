from __future__ import annotations

from intellwheels_agents.bridge.line_faults import Faults, FaultyLine


def sent(faults: Faults, name: str = "up", count: int = 2000) -> list[tuple[float, int]]:
    line: FaultyLine[int] = FaultyLine(faults, name)
    for number in range(count):
        line.send(number, 0.05 * number)
    return line.receive(1e9)


def test_a_line_without_faults_delivers_at_once() -> None:
    line: FaultyLine[str] = FaultyLine(Faults(), "up")
    line.send("a", 1.0)
    assert line.receive(0.99) == []
    assert line.receive(1.0) == [(1.0, "a")]
    assert line.receive(9.0) == []


def test_the_same_seed_gives_the_same_faults() -> None:
    faults = Faults(0.1, 0.2, 0.3, "7")
    assert sent(faults) == sent(faults)
    assert sent(faults) != sent(faults, "down")
    assert sent(faults) != sent(Faults(0.1, 0.2, 0.3, "8"))


def test_loss_and_delay_are_as_configured() -> None:
    came = sent(Faults(0.1, 0.2, 0.3))
    assert abs(len(came) / 2000 - 0.7) < 0.04  # four standard deviations
    late = [due - 0.05 * number for due, number in came]
    assert min(late) >= 0.1 - 1e-9
    assert max(late) < 0.3
    assert [due for due, _ in came] == sorted(due for due, _ in came)
    assert [number for _, number in came] != sorted(number for _, number in came)


def test_delays_do_not_depend_on_the_loss() -> None:
    whole = {number: due for due, number in sent(Faults(0.0, 0.2, 0.0))}
    assert all(whole[number] == due for due, number in sent(Faults(0.0, 0.2, 0.5)))


def test_a_reset_line_repeats_its_faults() -> None:
    line: FaultyLine[int] = FaultyLine(Faults(0.0, 1.0, 0.5), "up")
    rounds = []
    for _ in range(2):
        for number in range(50):
            line.send(number, 0.0)
        rounds.append(line.receive(10.0))
        line.send(99, 0.0)
        line.reset()
    assert rounds[0] == rounds[1]
