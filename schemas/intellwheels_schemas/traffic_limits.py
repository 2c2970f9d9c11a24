"""How much a router lets through: bytes of each kind of key, and messages a second of each agent. Pure.

A rate is counted for each session and each rule. One rule over many keys would have one budget for all of them, so each
agent of an identity has rules of its own, one for each key.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from intellwheels_schemas.access_rules import written_keys
from intellwheels_schemas.channels import CHANNELS, VERB_CLASSES
from intellwheels_schemas.codec import LIMITS, MAX_BYTES
from intellwheels_schemas.keys import AGENT_VERBS, ROOT
from intellwheels_schemas.messages import May

RATE: Final = 5000.0
"""Messages a second that an agent may send on one key. A second message within 0.2 ms is dropped. Lockstep, where an
agent answers once for each message that it gets, takes longer than that through a router."""

_PARTS: Final = ("<agent>", "<role>", "<instance>", "<since>", "<part>", "<crew>")


def size_limits() -> list[dict[str, Any]]:
    """Return Zenoh's `low_pass_filter`: the longest put and the longest query of each kind of key, in bytes."""
    keys: dict[int, list[str]] = {}
    for name, channel in CHANNELS.items():
        key = f"{ROOT}/*/{channel.key}"
        for part in _PARTS:
            key = key.replace(part, "*")
        if channel.kind == "token":
            continue
        if "<verb>" in key:
            for verb, record in VERB_CLASSES.items():
                if (verb in AGENT_VERBS) == (name == "ctl_agent"):
                    keys.setdefault(LIMITS[record], []).append(key.replace("<verb>", verb))
        else:
            limit = max(LIMITS.get(record, MAX_BYTES) for record in channel.carries)
            keys.setdefault(limit, []).append(key)
    return [
        {
            "id": f"at-most-{limit}", "flows": ["ingress"], "messages": ["put", "query"], "key_exprs": of,
            "size_limit": limit,
        }
        for limit, of in sorted(keys.items())
    ]  # fmt: skip


def rates(given: Iterable[May]) -> list[dict[str, Any]]:
    """Return Zenoh's `downsampling` for what identities may do: at most `RATE` messages a second on each key.

    Other queries than joins and leaves have no rate: Zenoh would drop the second of two honest ones at a time, of any
    session. The simulator answers them between ticks, for a bounded time.
    """
    entries = [may for may in given if may.role != "simulator"]
    wanted = {
        "put": [name for name, channel in CHANNELS.items() if channel.kind == "put" and channel.writer != "simulator"],
        "query": ["join", "leave", "crew_join", "crew_leave"],
    }
    found = []
    for message, names in wanted.items():
        keys = dict.fromkeys(key for may in entries for name in names for key in written_keys(name, may))
        rules = [{"key_expr": key, "freq": RATE} for key in keys]
        # Zenoh refuses an item without rules.
        found += [{"id": message, "flows": ["ingress"], "messages": [message], "rules": rules}] if rules else []
    return found
