"""The points that a program must pass to meet the contract, in their order. Pure: it uses a `Probe`.

Each point reports what was expected and what happened. After a failed point the program is killed, and the next point
starts a new one. So one fault fails one point. The first line of a point's docstring says what the program must do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final, NamedTuple

from intellwheels_experiments.conformance import input_points, join_points, message_points, tick_points
from intellwheels_experiments.conformance.agent_session import AgentSession, Patience, PointError
from intellwheels_experiments.conformance.probe import Probe
from intellwheels_schemas.messages import Robot

POINTS: Final[Mapping[str, Callable[[AgentSession], str]]] = {
    "join": join_points.join,
    "refusal": join_points.refusal,
    "token": join_points.token,
    "ticks": tick_points.ticks,
    "lost": tick_points.lost,
    "again": tick_points.again,
    "late": tick_points.late,
    "names": message_points.names,
    "encoding": message_points.encoding,
    "congestion": message_points.congestion,
    "say": message_points.say,
    "reset": tick_points.reset,
    "restart": join_points.restart,
    "unknown": input_points.unknown,
    "hostile": input_points.hostile,
    "leave": join_points.leave,
}
"""The points by name, in the order in which they are checked."""


class Outcome(NamedTuple):
    """The outcome of a point.

    Attributes:
        point: The point's name.
        passed: Whether the program passed; None if the point could not be checked.
        expected: What was expected; of a passed point, what was observed.
        got: What happened instead.
        output: What the program printed, if it failed.
    """

    point: str
    passed: bool | None
    expected: str
    got: str
    output: str = ""


def described() -> str:
    """Return one line per point: its name, and what the program must do."""
    return "\n".join(f"{name:<10} {(point.__doc__ or '').splitlines()[0]}" for name, point in POINTS.items())


def check(probe: Probe, world: str, agent: str, body: Robot, patience: Patience | None = None) -> Iterator[Outcome]:
    """Check all points and yield the outcome of each.

    Args:
        probe: The program and the network.
        world: The world's name.
        agent: The name under which the program must join.
        body: The body that a program of role `mind` gets.
        patience: How long the program may take.
    """
    session = AgentSession(probe, world, agent, body, patience or Patience())
    probe.start_simulator()
    joins = True
    for name, point in POINTS.items():
        if not joins:
            yield Outcome(name, None, "a program that joins", "none")
            continue
        try:
            observed = point(session)
        except PointError as error:
            yield Outcome(name, False, error.expected, error.got, probe.output())
            joins = name != "join"
            session.close()
        else:
            yield Outcome(name, True, observed, "")
    session.close()
