"""Tells the answers of a world's simulator from those of others. Pure: what is known of the network is passed in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol, TypeVar

from intellwheels_schemas.keys import Keys


class Reply(Protocol):
    """An answer to a query, with the id of the session that sent it."""

    @property
    def replier(self) -> str:
        """Zenoh's id of that session, at most 32 hex digits."""


_R = TypeVar("_R", bound=Reply)


def mark_of(zid: str) -> str:
    """Return the 16 hex digits by which a session claims a world: the first half of its Zenoh id."""
    return zid.zfill(32)[:16]


def by_simulator(answers: Sequence[_R], keys: Keys, find_claims: Callable[[], Iterable[str]]) -> list[_R]:
    """Return the answers of the world's simulator. Anybody can answer a query in an open world.

    If several sessions answered, the simulator is the one that claimed the world first. Without its claim there is no
    telling, so none of them counts.

    Args:
        answers: All answers to one query.
        keys: The keys of the world.
        find_claims: Returns the keys of the liveliness tokens that match `keys.every_claim`. Called only if needed.
    """
    if len({answer.replier for answer in answers}) < 2:
        return list(answers)
    claims = sorted(claim for key in find_claims() if (claim := keys.parse_claim(key)) is not None)
    return [answer for answer in answers if claims and mark_of(answer.replier) == claims[0].instance]
