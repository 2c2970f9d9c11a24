"""How many bytes of each kind of key a router lets through. Pure.

A router limits no rate. Zenoh's `downsampling` keeps a least time between two messages, of all keys of a rule, as they
pass through the router. It would drop what the chairs of one session answer to a tick, two `Say` in a row, and the
newest of those messages that a slow network delivers together. The simulator limits each agent instead.
"""

from __future__ import annotations

from typing import Any, Final

from intellwheels_schemas.channels import CHANNELS, VERB_CLASSES
from intellwheels_schemas.codec import LIMITS, MAX_BYTES
from intellwheels_schemas.keys import AGENT_VERBS, ROOT

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
