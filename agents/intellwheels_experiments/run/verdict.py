"""Whether a run did what its scene says must hold. Pure: a scene, its floor and a record in, a verdict out.

Judged by true poses and by events, never by what an agent believes of itself.
"""

from __future__ import annotations

import math

from msgspec import Struct

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.messages import Map, Scene


class Row(Struct, frozen=True, kw_only=True):
    """What one agent of the cast did.

    Attributes:
        name: The agent.
        mind: Its mind, as the scene names it.
        robot: Its body, as the scene names it.
        place: The place it had to reach, None if none.
        distance: Of its centre of movement from that place when last seen, in m; None without either.
        reached: Whether that distance is within what the scene asks; None without a place.
        contacts: Episodes of contact.
        path: Length of its path as far as seen, a lower bound, in m.
        turned: Greatest turn away from its first heading, in rad, in [0, pi].
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
    seen: bool = False


class Verdict(Struct, frozen=True, kw_only=True):
    """What came of a run.

    Attributes:
        held: Whether everything held that had to.
        failed: A sentence for each thing that did not.
        agents: A row for each of the cast, in its order.
        contacts: Number of contacts of the run: two bodies that touch are one.
    """

    held: bool
    failed: tuple[str, ...]
    agents: tuple[Row, ...]
    contacts: int


def judge(scene: Scene, floor: Map, record: RunRecord, *, ended: bool = True) -> Verdict:
    """Return the verdict on a run.

    Args:
        scene: What was run.
        floor: The floor of the scene, for its places.
        record: What was seen.
        ended: Whether the run came to its end; one that was broken off does not hold.
    """
    rows = _rows(scene, floor, record)
    contacts = record.counts.get("contact", 0)
    failed = []
    if not ended:
        failed.append("the run did not come to its end")
        if not record.tracks:
            # What was never begun fell short of everything, which helps nobody to see why.
            return Verdict(held=False, failed=tuple(failed), agents=rows, contacts=contacts)
    failed += [f"agent {row.name!r} was never seen" for row in rows if not row.seen]
    hold = scene.hold
    if hold is not None and hold.contacts is not None:
        # A body's own count stands even when more happened than the simulator keeps events for.
        most = max([contacts, *(row.contacts for row in rows)])
        if most > hold.contacts:
            failed.append(f"contacts: expected at most {hold.contacts}, got {most}")
    if hold is not None and hold.reached == "all":
        failed += [_shortfall(row) for row in rows if row.reached is False]
    return Verdict(held=not failed, failed=tuple(failed), agents=rows, contacts=contacts)


def _rows(scene: Scene, floor: Map, record: RunRecord) -> tuple[Row, ...]:
    places = {place.name: place for place in floor.grid.position} if floor.grid else {}
    goals = {reach.agent: reach for reach in scene.end.reach} if scene.end else {}
    rows = []
    for cast in scene.cast:
        reach = goals.get(cast.name)
        place = places[reach.place] if reach else None
        track = record.tracks.get(cast.name)
        distance = math.hypot(track.last.x - place.x, track.last.y - place.y) if track and place else None
        rows.append(
            Row(
                name=cast.name,
                mind=cast.mind,
                robot=cast.robot,
                place=reach.place if reach else None,
                distance=distance,
                # Poses on the wire are rounded to 1e-6 m.
                reached=(distance is not None and distance <= reach.within + 2e-6) if reach else None,
                contacts=track.last.contacts if track else 0,
                path=track.length if track else 0.0,
                turned=track.turned if track else 0.0,
                seen=track is not None,
            )
        )
    return tuple(rows)


def _shortfall(row: Row) -> str:
    if row.distance is None:
        return f"agent {row.name!r} did not reach {row.place!r}"
    return f"agent {row.name!r} did not reach {row.place!r}: {row.distance:.2f} m short of it"
