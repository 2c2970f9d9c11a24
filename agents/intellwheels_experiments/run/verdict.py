"""Whether a run met the conditions of its scene. Pure: a scene, its map and a record in, a verdict out.

The verdict uses true poses and events only, never the estimates of an agent.
"""

from __future__ import annotations

import math

from msgspec import Struct

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.messages import Map, Scene


class AgentResult(Struct, frozen=True, kw_only=True):
    """The result of one agent of the cast.

    Attributes:
        name: The agent.
        mind: Its mind or command, as the scene has it.
        robot: Its body, as the scene names it.
        place: The place that it had to reach; None without one.
        distance: From its centre of movement to that place when last seen, in m; None if there is no place, or if the
            agent was never seen.
        reached: Whether the distance is within the scene's limit; None without a place.
        contacts: Number of contacts. A contact that lasts counts once.
        path: Length of its path, in m. It and `turned` are the simulator's sums over all ticks.
        turned: Largest angle from its first heading, in rad, in [0, pi].
        command_age: Mean age of its commands when they took effect, in s; 0 if none was late.
        seen: Whether it was seen at all.
    """

    name: str
    mind: str
    robot: str
    place: str | None = None
    distance: float | None = None
    reached: bool | None = None
    contacts: int = 0
    path: float = 0.0
    turned: float = 0.0
    command_age: float = 0.0
    seen: bool = False


class Verdict(Struct, frozen=True, kw_only=True):
    """The verdict on a run.

    Attributes:
        held: Whether all conditions held.
        failed: A sentence for each condition that did not.
        agents: One result per agent of the cast, in its order.
        contacts: Number of contacts of the run. A contact of two bodies counts once.
    """

    held: bool
    failed: tuple[str, ...]
    agents: tuple[AgentResult, ...]
    contacts: int


def judge(scene: Scene, floor: Map, record: RunRecord, *, ended: bool = True) -> Verdict:
    """Return the verdict on a run.

    Args:
        scene: The scene that was run.
        floor: Its map, for the places.
        record: What was seen of the run.
        ended: Whether the run reached its end. The conditions of an aborted run do not hold.
    """
    agents = _agents(scene, floor, record)
    contacts = record.counts.get("contact", 0)
    failed = []
    if not ended:
        failed.append("the run did not reach its end")
        if not record.tracks:
            # A run that never began misses every condition. Listing them would hide the cause.
            return Verdict(held=False, failed=tuple(failed), agents=agents, contacts=contacts)
    failed += [f"agent {agent.name!r} was never seen" for agent in agents if not agent.seen]
    hold = scene.hold
    if hold is not None and hold.contacts is not None:
        # A body's own count is complete even where the simulator no longer has all events.
        most = max([contacts, *(agent.contacts for agent in agents)])
        if most > hold.contacts:
            failed.append(f"contacts: expected at most {hold.contacts}, got {most}")
    if hold is not None and hold.reached == "all":
        failed += [_shortfall(agent) for agent in agents if agent.reached is False]
    return Verdict(held=not failed, failed=tuple(failed), agents=agents, contacts=contacts)


def _agents(scene: Scene, floor: Map, record: RunRecord) -> tuple[AgentResult, ...]:
    places = {place.name: place for place in floor.grid.position} if floor.grid else {}
    goals = {reach.agent: reach for reach in scene.end.reach} if scene.end else {}
    agents = []
    for cast in scene.cast:
        reach = goals.get(cast.name)
        place = places[reach.place] if reach else None
        track = record.tracks.get(cast.name)
        distance = math.hypot(track.last.x - place.x, track.last.y - place.y) if track and place else None
        agents.append(
            AgentResult(
                name=cast.name,
                mind=cast.command or cast.mind,
                robot=cast.robot,
                place=reach.place if reach else None,
                distance=distance,
                # Poses on the wire are rounded to 1e-6 m.
                reached=(distance is not None and distance <= reach.within + 2e-6) if reach else None,
                contacts=track.last.contacts if track else 0,
                path=track.length if track else 0.0,
                turned=track.turned if track else 0.0,
                command_age=track.last.command_age if track else 0.0,
                seen=track is not None,
            )
        )
    return tuple(agents)


def _shortfall(agent: AgentResult) -> str:
    if agent.distance is None:
        return f"agent {agent.name!r} did not end at {agent.place!r}"
    return f"agent {agent.name!r} did not end at {agent.place!r}: it ended {agent.distance:.2f} m away"
