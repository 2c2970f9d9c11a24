"""The points about unusual input. Each returns what it observed, or raises `PointError`."""

from __future__ import annotations

import json
from typing import Final

from intellwheels_experiments.conformance.agent_session import AgentSession
from intellwheels_schemas.codec import Encoding

HOSTILE: Final = (
    "]]></Message></Measures><Measures Run='0000000000000000' Tick='99' Time='1.0'/>",
    '","Tick":99,"Run":"0000000000000000","x":"',
    "</Say>&amp;&lt;&#0;<!-- <![CDATA[ <!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]> &b;",
    "$(kill -9 $PPID) `exit` ; rm -rf . | %s%n%x {0} {name} ${HOME} \\u0000 \\x00 \\",
    "'; DROP TABLE chairs; -- \" ' ` \t\n\n\tTick 99",
    "\u202e\u200b\ufeff\u0085\u2028\u2029 \U0001f468\u200d\U0001f9bd \U0010fffd e\u0301 \u65e0",
    "9" * 1000,
)
"""Valid texts that a careless reader takes for something else."""


def unknown(session: AgentSession) -> str:
    """Gets fields and elements that its version does not know: ignores them."""
    session.require_joined()
    session.exchange(extended)
    session.exchange()
    return "answered as if they were absent"


def hostile(session: AgentSession) -> str:
    """Hears texts that look like markup, commands or other messages: treats them as text."""
    session.require_joined()
    session.put_error("value", HOSTILE[0])
    for text in HOSTILE:
        session.exchange(heard=text)
    session.exchange()
    return f"{len(HOSTILE)} texts heard, all answered"


def extended(payload: bytes, encoding: Encoding) -> bytes:
    """Return encoded Measures with fields and records that a later version might add."""
    if encoding is Encoding.JSON:
        plain = json.loads(payload)
        plain |= {"Weather": {"Rain": None, "Wind": [1.5, "N"]}, "Mood": [1, "two"]}
        sensors = plain.setdefault("Sensors", {})
        for kind in sensors.values():
            for reading in kind:
                reading["Confidence"] = 0.5
        sensors["Nose"] = [{"Id": "nose", "Smell": "coffee"}]
        return json.dumps(plain, separators=(",", ":")).encode()
    text = payload.decode().replace("<Measures ", '<Measures Mood="1" ', 1)
    if text.endswith("/>"):
        text = text[:-2] + "></Measures>"
    weather = '<Weather Rain="0.0">text</Weather>'
    nose = '<Nose Id="nose" Smell="coffee"/></Sensors>'
    return text.replace("</Sensors>", nose, 1).replace("</Measures>", weather + "</Measures>", 1).encode()
