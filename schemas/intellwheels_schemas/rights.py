"""What an identity of a lab may not do, in words, by the rules that its router enforces. Pure.

A router drops what is not allowed and says nothing. So a denial looks as if there were no simulator.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

from intellwheels_schemas.access_rules import Flow, rules_for
from intellwheels_schemas.keys import ROOT
from intellwheels_schemas.messages import Identity, LabRole, Role

Does: TypeAlias = Literal["query", "put", "read", "watch"]
"""What is done with a key: query it, put to it, subscribe to it, or watch its liveliness token."""

RIGHTS: Final = f"{ROOT}/@rights"
"""Below it, the router of a lab answers each identity what it may do. No key of a world begins so."""

_NEEDS: Final[dict[Does, tuple[str, Flow]]] = {
    "query": ("query", "ingress"), "put": ("put", "ingress"), "read": ("put", "egress"),
    "watch": ("liveliness_token", "egress"),
}  # fmt: skip
_WORDS: Final[dict[Does, str]] = {"query": "ask for", "put": "write", "read": "read", "watch": "see"}
_JOINS: Final[dict[Role, tuple[LabRole, ...]]] = {
    "both": ("agent", "gateway"), "mind": ("agent", "mind", "gateway"), "body": ("bridge",),
}  # fmt: skip
"""The roles of a lab that allow a role of an agent."""
_PARTS: Final[dict[Role, str]] = {"both": "body and mind", "mind": "mind", "body": "body"}


def rights_key(name: str) -> str:
    """Return the key at which an identity reads what it may do: the reply is its `Identity`."""
    return f"{RIGHTS}/{name}"


def denial(who: Identity, key: str, does: Does = "query") -> str:
    """Return in words that an identity may not do something; empty if it may.

    Args:
        who: The identity, with everything that it may do.
        key: A key of a world; wildcards must be allowed as a whole.
        does: What is done with the key.
    """
    message, flow = _NEEDS[does]
    rules = [rule for may in who.may for rule in rules_for(may) if message in rule.messages and rule.flow == flow]
    if any(_covers(pattern, key) for rule in rules for pattern in rule.keys):
        return ""
    world, _, rest = key.removeprefix(f"{ROOT}/").partition("/")
    # A crew has the right to a name that its agents' names match.
    names = [name for may in who.may for name in may.agents if may.world == world and may.role in _JOINS["mind"]]
    crews = f", only as {', '.join(names)}" if names and rest.startswith("crew/") else ""
    return f"{sentence(who.name, _WORDS[does], key)}{crews or _elsewhere(who, world)}"


def sentence(name: str, verb: str, key: str) -> str:
    """Return in words that somebody may not do something with a key."""
    if not key.startswith(f"{ROOT}/"):
        return f"{name} may not {verb} {key}"
    world, _, rest = key.removeprefix(f"{ROOT}/").partition("/")
    return f"{name} may not {verb} {rest} in world {world}"


def join_denial(who: Identity, world: str, role: Role, agent: str) -> str:
    """Return in words that an identity may not join as an agent; empty if it may."""
    given = [may for may in who.may if may.world == world and may.role in _JOINS[role]]
    names = [pattern for may in given for pattern in may.agents]
    if any(agent.startswith(one[:-1]) if one.endswith("*") else agent == one for one in names):
        return ""
    instead = f", only {', '.join(names)}" if names else _elsewhere(who, world) or ", nobody there"
    return f"{who.name} may not be the {_PARTS[role]} of '{agent}' in world {world}{instead}"


def serve_denial(who: Identity, world: str) -> str:
    """Return in words that an identity may not be the simulator of a world; empty if it may."""
    if any(may.role == "simulator" and may.world == world for may in who.may):
        return ""
    worlds = sorted({may.world for may in who.may if may.role == "simulator"})
    return f"{who.name} may not be the simulator of world {world}{_only_in(worlds)}"


def _elsewhere(who: Identity, world: str) -> str:
    worlds = sorted({may.world for may in who.may})
    return "" if world in worlds else _only_in(worlds)


def _only_in(worlds: list[str]) -> str:
    return f", only in {', '.join(worlds)}" if worlds else ""


def _covers(pattern: str, key: str) -> bool:
    """Return whether a key expression of a rule includes a key."""
    wanted, given = pattern.split("/"), key.partition("?")[0].split("/")
    for place, chunk in enumerate(wanted):
        if chunk == "**":
            return True
        if place >= len(given) or not _chunk_covers(chunk, given[place]):
            return False
    return len(wanted) == len(given)


def _chunk_covers(wanted: str, given: str) -> bool:
    if wanted == "*":
        return given != "**"
    if wanted.endswith("$*"):
        return given.startswith(wanted[:-2])
    return wanted == given
