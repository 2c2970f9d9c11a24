"""Who may do what: one table of keys and roles, from which both KEYS.md and the rules of a router are made. Pure.

A router denies what no rule allows. Each rule has messages of Zenoh, a direction as the router sees it (`ingress`: from
the identity; `egress`: to it), and key expressions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, Literal, NamedTuple

from intellwheels_schemas.channels import CHANNELS, Channel
from intellwheels_schemas.keys import AGENT_VERBS, ROOT, VERBS
from intellwheels_schemas.messages import LabRole, May

Flow = Literal["ingress", "egress"]
Access = Literal["writes", "reads", "both"]

_AGENTS: Final[tuple[LabRole, ...]] = ("agent", "mind", "gateway")
_LOOKERS: Final[tuple[LabRole, ...]] = ("operator", "viewer", "recorder", "gateway")
_OTHERS: Final[tuple[LabRole, ...]] = ("operator", "viewer", "agent", "mind", "bridge", "recorder", "gateway")


def _row(simulator: Access, writes: Iterable[LabRole] = (), reads: Iterable[LabRole] = ()) -> dict[LabRole, Access]:
    found: dict[LabRole, Access] = {"simulator": simulator, **dict.fromkeys(writes, "writes")}
    for role in reads:
        found[role] = "both" if role in found else "reads"
    return found


ACCESS: Final[dict[str, dict[LabRole, Access]]] = {
    "join": _row("reads", (*_AGENTS, "bridge")),
    "leave": _row("reads", (*_AGENTS, "bridge")),
    "actions": _row("reads", _AGENTS, ("recorder",)),
    "say": _row("reads", _AGENTS, ("recorder",)),
    "pose": _row("both", ("bridge",), ("recorder",)),
    "token": _row("reads", (*_AGENTS, "bridge"), ("recorder",)),
    "user": _row("reads", ("operator", "viewer", "bridge"), ("recorder",)),
    "measures": _row("writes", (), _OTHERS),
    "power": _row("writes", (), ("bridge", "recorder")),
    "error": _row("writes", (), _OTHERS),
    "body": _row("writes", (), _OTHERS),
    "state": _row("writes", (), _LOOKERS),
    "map": _row("writes", (), _OTHERS),
    "event": _row("writes", (), (*_LOOKERS, "bridge")),
    "clock": _row("writes", (), _OTHERS),
    "crew_token": _row("reads", _AGENTS, ("recorder",)),
    "crew_join": _row("reads", _AGENTS),
    "crew_leave": _row("reads", _AGENTS),
    "crew_actions": _row("reads", _AGENTS, ("recorder",)),
    "crew_measures": _row("writes", (), _OTHERS),
    "crew_error": _row("writes", (), _OTHERS),
    "ctl": _row("reads", ("operator",)),
    "ctl_agent": _row("reads", ("operator", "viewer")),
    "alive": _row("both", (), _OTHERS),
    "claim": _row("both", (), _OTHERS),
}
"""What each role may do with each key of `CHANNELS`. Who queries a key writes it; who answers reads it."""

OVERSEES: Final[frozenset[LabRole]] = frozenset({"operator", "viewer", "recorder"})
"""Roles that may read about every agent. They write for those of their `Agents` only."""

TOKEN_ROLES: Final[dict[LabRole, tuple[str, ...]]] = {
    "agent": ("both", "mind"), "mind": ("mind",), "bridge": ("body",), "gateway": ("both", "mind"),
}  # fmt: skip
"""The roles of the liveliness tokens that an identity may declare."""

_SENDS: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "put": (("put",), ()),
    "query": (("query",), ("reply",)),
    "token": (("liveliness_token",), ()),
}
"""What the writer of a kind of key sends, and what it gets."""
_TAKES: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "put": (("declare_subscriber",), ("put",)),
    "query": (("declare_queryable", "reply"), ("query",)),
    "token": (("declare_liveliness_subscriber", "liveliness_query"), ("liveliness_token",)),
}
"""What the reader of a kind of key sends, and what it gets."""
EVERY_MESSAGE: Final = (
    "put", "delete", "declare_subscriber", "query", "declare_queryable", "reply", "liveliness_token",
    "liveliness_query", "declare_liveliness_subscriber",
)  # fmt: skip


class Rule(NamedTuple):
    """A rule that allows."""

    messages: tuple[str, ...]
    flow: Flow
    keys: tuple[str, ...]


def rules_for(may: May) -> list[Rule]:
    """Return the rules of one entry of an identity, those with the same messages as one."""
    if may.role == "simulator":
        everything = (f"{ROOT}/{may.world}/**",)
        return [Rule(EVERY_MESSAGE, "ingress", everything), Rule(EVERY_MESSAGE, "egress", everything)]
    # Who declared what is no secret. A publisher that does not hear of the simulator's wide subscription sends nothing.
    declared = ("declare_subscriber", "declare_queryable")
    found: dict[tuple[tuple[str, ...], Flow], dict[str, None]] = {
        (declared, "egress"): {f"{ROOT}/{may.world}/**": None}
    }

    def add(messages: tuple[str, ...], flow: Flow, keys: Sequence[str]) -> None:
        # Zenoh refuses a rule without keys, such as that of a viewer that may steer nobody.
        if messages and keys:
            found.setdefault((messages, flow), {}).update(dict.fromkeys(keys))

    for name, roles in ACCESS.items():
        access, channel = roles.get(may.role), CHANNELS[name]
        if access in ("writes", "both"):
            sends, gets = _SENDS[channel.kind]
            keys = _keys(name, channel, may, writes=True)
            add(sends, "ingress", keys)
            add(gets, "egress", keys)
        if access in ("reads", "both"):
            sends, gets = _TAKES[channel.kind]
            keys = _keys(name, channel, may, writes=False)
            add(sends, "ingress", [*keys, *_declared(name, may)])
            add(gets, "egress", keys)
            if channel.get:
                add(("query",), "ingress", keys)
                add(("reply",), "egress", keys)
    return [Rule(messages, flow, tuple(keys)) for (messages, flow), keys in found.items()]


def written_keys(name: str, may: May) -> list[str]:
    """Return the key expressions of a channel on which an entry of an identity may put, or send queries."""
    allowed = ACCESS[name].get(may.role, "") in ("writes", "both")
    return _keys(name, CHANNELS[name], may, writes=True) if allowed else []


def _declared(name: str, may: May) -> list[str]:
    """Return what a reader declares beyond the keys that it gets: an agent subscribes to all of its own."""
    if name == "alive":
        return [f"{ROOT}/*/alive"]
    if name == "error" and may.role not in OVERSEES:
        return [f"{ROOT}/{may.world}/out/{_expression(pattern)}/*" for pattern in may.agents]
    return []


def _keys(name: str, channel: Channel, may: May, *, writes: bool) -> list[str]:
    key = f"{ROOT}/{may.world}/{channel.key}"
    for part in ("<instance>", "<since>", "<part>"):
        key = key.replace(part, "*")
    # A token names the agent first: by it, the owner of the agent allows a crew of any name to act for it. Else the
    # crew's own name must be one that the identity may use for agents.
    key = key.replace("<crew>", "*" if "<agent>" in key else "<agent>")
    agents = [_expression(pattern) for pattern in may.agents]
    if not writes and may.role in OVERSEES:
        agents = ["*"]
    if name in ("ctl", "ctl_agent"):
        return [key.replace("<verb>", verb).replace("<agent>", agent) for verb in _verbs(name, may)
                for agent in (agents if name == "ctl_agent" else [""])]  # fmt: skip
    roles = TOKEN_ROLES.get(may.role, ()) if writes else ("*",)
    keys = [key.replace("<role>", role) for role in (roles if "<role>" in key else ("",))]
    return [one.replace("<agent>", agent) for one in keys for agent in (agents if "<agent>" in key else [""])]


def _verbs(name: str, may: May) -> list[str]:
    if may.role == "viewer":
        return ["take"]
    return [verb for verb in may.verbs or VERBS if (verb in AGENT_VERBS) == (name == "ctl_agent")]


def _expression(pattern: str) -> str:
    """Return a pattern of names as Zenoh writes it: `st1-*` is `st1-$*`."""
    return pattern if pattern == "*" or not pattern.endswith("*") else f"{pattern[:-1]}$*"
