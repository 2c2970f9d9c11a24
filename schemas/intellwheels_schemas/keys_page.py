"""KEYS.md: what travels on which key, who writes it, every field, limit and code, for people."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from intellwheels_schemas import codes, rules
from intellwheels_schemas.channels import CHANNELS, VERB_CLASSES, Channel
from intellwheels_schemas.codec import LIMITS, MAX_BYTES
from intellwheels_schemas.explain import expected
from intellwheels_schemas.messages import (
    Load,
    Map,
    OperatorSay,
    Pose,
    Record,
    Robot,
    Scene,
    UserInput,
)
from intellwheels_schemas.names import EXPECTED, RESERVED
from intellwheels_schemas.shapes import Form, Member, number_text, shape_of
from intellwheels_schemas.vectors import NAMES

_HEAD = """<!-- Made by python -m intellwheels_schemas from the message classes; do not edit. -->

# Keys, messages, limits and codes

Every key begins with `iw/v1/<world>/`. `<world>`, `<agent>` and `<crew>` are {name}; reserved: {reserved}. Start
with [FIRST-AGENT.md](FIRST-AGENT.md); exact bytes are in [vectors](vectors), schemas in [xsd](xsd) and
[json](json).

## Keys
"""

_NOTES = """
- Every put is sent with congestion control *drop*: nothing waits for a slow reader, so receivers count gaps in
  `Tick` and `Seq`.
- An error reply to a query carries the message in the last column. A query nobody answers comes back empty at once:
  no simulator there, or not allowed.
- Order is (`Run`, `Tick`): a new `Run` (start, reset, load) clears what a receiver knew.
- `join` takes `?session=S`, the `Session` of the last join: who shows it gets its seat and body back though the old
  process's token is still there; without it the name is `already-here` until that token is gone.
- An agent says one thing a tick. A `Say` beside `Actions` that speak too is not heard: its sender gets an Error
  `too-many`.
- `event` takes `?since=N`; the reply names the oldest event kept. Ask for `state/*` after subscribing to it, and
  drop what is older.
- Worlds are found by asking for the liveliness of `iw/v1/*/alive`.
- A speaker may put a `Say` as `text/plain` too.

## Encodings

| Encoding | Payload |
|---|---|
| `application/json;iw.v1` | the bare object |
| `application/xml;iw.v1` | an element named as the class |
| `text/plain` | the text, on `in/<agent>/say` only |
| none, `zenoh/bytes`, `zenoh/string` | the first byte decides: `{` or `<` |

`;iw.v1` may be absent. Every input is taken in either encoding; `out/<agent>/...` comes in that of the role's
`join`: measures in the mind's, power in the body's. Shared puts (`state`, `clock`, `event`, `map`, `body`) are
JSON, a `get` is answered in the encoding asked with.

- Fields are attributes in XML, records child elements, lists repeated child elements, lists of scalars one
  attribute separated by spaces. JSON arrays stand under the same singular name. `Text` is the element's text.
- Defaults and empty lists are not written. `null` is refused but in a lidar's `Ranges` (`-` in XML). A name stands
  once.
- Numbers have JSON's grammar in both: no `+5`, `.5`, `007`, `NaN`, `INF`; no fraction or exponent in a whole
  number.
- Text has XML 1.0's characters without carriage return; lengths count code points. XML has no document type and no
  entities of its own.
- The simulator refuses unknown fields; everybody else ignores them.
- Errors name places as here, lists counted from 0: `Robot.Proximity[2].ConeDeg: expected degrees in (0, 360], got
  0`.

## Limits
"""


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    names = list(head)
    lines = [f"| {' | '.join(names)} |", f"|{'---|' * len(names)}"]
    lines += [f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |" for row in rows]
    return "\n".join(lines) + "\n"


def _name(cls: type[Record]) -> str:
    return next(name for name, one in NAMES.items() if one is cls)


def _linked(classes: Iterable[type[Record]]) -> str:
    return ", ".join(f"[{_name(cls)}](#{_name(cls).lower()})" for cls in classes)


def _row(channel: Channel) -> tuple[str, ...]:
    kind = f"{channel.kind}, get" if channel.get else channel.kind
    quality = f"{channel.priority}{', express' if channel.express else ''}" if channel.kind == "put" else ""
    return (
        f"`{channel.key}`", channel.writer, kind, quality, channel.often, _linked(channel.carries),
        _linked(channel.replies), _linked(channel.errors),
    )  # fmt: skip


def _limits() -> str:
    rows = [(f"bytes of {_name(cls)}", f"{LIMITS[cls]:,}") for cls in (Robot, Pose, UserInput, Load)]
    rows[2] = (f"bytes of Actions, {_name(UserInput)}, Say, Leave and small verbs", f"{LIMITS[UserInput]:,}")
    rows += [
        ("bytes of anything else", f"{MAX_BYTES:,}"),
        ("characters of a name, an id", "32"),
        ("characters of a word, a seed", "64"),
        ("characters of text", "1,000; a simulation's own `SayLimit` is lower"),
        ("parts of a robot", str(rules.MAX_PARTS)),
        ("sensors of a robot", str(rules.MAX_SENSORS)),
        ("rays of a lidar", f"{rules.MAX_RAYS:,}"),
        ("bodies of a crew", str(rules.MAX_CREW)),
        ("X and Y", "within 10,000 m"),
        ("whole numbers", "0 to 2^53 - 1"),
    ]
    return _table(("What", "At most"), rows)


def _codes(meanings: Mapping[str, str]) -> str:
    return _table(("Code", "Means"), ((f"`{code}`", text) for code, text in meanings.items()))


def _verbs() -> str:
    rows = []
    for verb, cls in VERB_CLASSES.items():
        ros = codes.ROS_VERB[verb]
        rows.append((f"`ctl/{verb}`", _linked((cls,)), f"`{ros.service}`" if ros.service else "", ros.how))
    for key, ros in codes.ROS_KEY.items():
        rows.append((f"`{CHANNELS[key].key}`", "", f"`{ros.service}`", ros.how))
    return _table(("Key", "Message", "ROS service", "With"), rows)


def _default(member: Member) -> str:
    if member.required:
        return "**required**"
    if member.default is None or member.default == ():
        return ""
    if isinstance(member.default, bool):
        return "true" if member.default else "false"
    return number_text(member.default) if isinstance(member.default, int | float) else str(member.default)


def _field(member: Member) -> tuple[str, str, str, str]:
    scalar = member.scalar
    kind = f"<{member.wire}>" if member.record is not None else ""
    if member.record is not None:
        kind += f" [{member.record.__name__}](#{member.record.__name__.lower()})"
    if scalar is not None:
        kind = expected(scalar)
        if scalar.unit not in {"", "1", "deg", "rad", "m", "s", "m/s", "m/s2", "rad/s"}:
            kind += f" {scalar.unit}"
        if scalar.kind == "text" and not scalar.expected:
            kind = f"text, at most {scalar.max_length} characters"
    if member.form is Form.LIST:
        kind = f"list of: {kind}"
    elif member.form is Form.RECORDS:
        kind = f"any number of {kind}"
    elif member.form is Form.CONTENT:
        kind = f"{kind}; in XML the element's text"
    elif member.form is Form.ELEMENT:
        kind = f"{kind}; in XML an element"
    if member.max_count is not None:
        kind += f", at most {member.max_count}"
    description = member.description or (scalar.description if scalar is not None else "")
    return f"`{member.wire}`", kind.replace("<", "`<").replace(">", ">`"), _default(member), description


def _message(cls: type[Record], title: str) -> str:
    shape = shape_of(cls)
    doc = " ".join((cls.__doc__ or "").split())
    root = f" XML root `<{shape.root}>`." if cls is OperatorSay else ""
    fields = (
        _table(("Field", "Is", "Default", "Means"), map(_field, shape.members)) if shape.members else "No fields.\n"
    )
    return f"### {title}\n\n{doc}{root}\n\n{fields}\n"


def _records() -> list[type[Record]]:
    found: dict[type[Record], None] = {}

    def add(cls: type[Record]) -> None:
        for member in shape_of(cls).members:
            if member.record is not None and member.record not in found:
                found[member.record] = None
                add(member.record)

    for cls in NAMES.values():
        add(cls)
    return sorted((cls for cls in found if cls not in NAMES.values()), key=lambda cls: cls.__name__)


def keys_page() -> str:
    """Return the text of KEYS.md."""
    head = _HEAD.format(name=EXPECTED, reserved=", ".join(f"`{name}`" for name in sorted(RESERVED)))
    keys = _table(
        ("Key", "Writer", "Kind", "Priority", "How often", "Message", "Reply", "Error reply"),
        map(_row, CHANNELS.values()),
    )
    parts = [
        head, "\n", keys, _NOTES, "\n", _limits(),
        "\n## Codes\n\n### Of a refused join\n\n", _codes({str(code): text for code, text in codes.REFUSED.items()}),
        "\n### Of an error\n\n", _codes({str(code): text for code, text in codes.ERROR.items()}),
        "\n### Of an event\n\n", _codes({str(code): text for code, text in codes.EVENT.items()}),
        "\n### Of a result\n\n",
        _table(
            ("Code", "Means", "ROS `Result`"),
            ((f"`{code}`", text, codes.ROS_RESULT[code]) for code, text in codes.RESULT.items()),
        ),
        "\n## Control, and its ROS `simulation_interfaces` counterpart\n\n", _verbs(),
        "\n## Messages\n\n",
        *(_message(cls, name) for name, cls in NAMES.items() if cls not in {Map, Scene}),
        "## Files\n\nXML for people, comments and indentation welcome. ",
        "A robot file is a [Robot](#robot) with `Format`.\n\n",
        *(_message(cls, _name(cls)) for cls in (Map, Scene)),
        "## Records within messages\n\n", *(_message(cls, cls.__name__) for cls in _records()),
    ]  # fmt: skip
    return "".join(parts).rstrip("\n") + "\n"
