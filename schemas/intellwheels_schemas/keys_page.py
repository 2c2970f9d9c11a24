"""KEYS.md, the reference for people: all keys with their writers and messages, all fields, limits and codes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from msgspec import NODEFAULT, inspect

from intellwheels_schemas import codes, defaults, file_records, rules
from intellwheels_schemas import keys_prose as prose
from intellwheels_schemas.access_rules import ACCESS, OVERSEES
from intellwheels_schemas.channels import CHANNELS, VERB_CLASSES, Channel
from intellwheels_schemas.codec import LIMITS, MAX_BYTES, Encoding, encode
from intellwheels_schemas.explain import expected
from intellwheels_schemas.field_docs import field_docs
from intellwheels_schemas.file_records import LINES, FileRecord
from intellwheels_schemas.keys import AGENT_VERBS
from intellwheels_schemas.lab_rules import LAB_ROLES
from intellwheels_schemas.messages import (
    Lab,
    LidarReading,
    Load,
    Map,
    Measures,
    OperatorSay,
    Pose,
    Record,
    Robot,
    Scene,
    Sensors,
    Spawn,
    Status,
    UserInput,
)
from intellwheels_schemas.names import EXPECTED, RESERVED
from intellwheels_schemas.schema_gaps import GAPS
from intellwheels_schemas.shapes import Form, Member, number_text, scalar_of, shape_of
from intellwheels_schemas.vectors import NAMES, REFUSED, RUN

# A run of a day and a half at 20 ticks a second.
_MANY_TICKS = 2_000_000


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


def _notes() -> str:
    rays = 180
    ok: Status = "ok"
    scan = LidarReading(
        id="l" * 32, tick=_MANY_TICKS, stamp=100000.123456, start_deg=-134.99999, step_deg=1.5083798882681565,
        ranges=(12.345678,) * rays, statuses=(ok,) * rays,
    )  # fmt: skip
    message = Measures(run=RUN, tick=_MANY_TICKS, time=100000.123456, sensors=Sensors(lidar=(scan,)))
    sizes = (len(encode(message, encoding)) for encoding in (Encoding.JSON, Encoding.XML))
    notes = prose.NOTES.replace("<late>", f"{defaults.LATE_COMMAND:g}")
    return notes.replace("{scan_json:,}", f"{next(sizes):,}").replace("{scan_xml:,}", f"{next(sizes):,}")


def _schemas() -> str:
    accepted = {name for gap in GAPS for name in gap.vectors}
    text = prose.SCHEMAS.format(refused=len(REFUSED), accepted=len(accepted))
    return f"{text}{_table(('What', 'Language', 'Why'), ((gap.what, gap.language, gap.why) for gap in GAPS))}\n"


def _limits() -> str:
    rows = [(f"bytes of {_name(cls)}", f"{LIMITS[cls]:,}") for cls in (Robot, Spawn, Pose, UserInput, Load)]
    rows[3] = (f"bytes of Actions, {_name(UserInput)}, Say, Leave and any other control verb", f"{LIMITS[UserInput]:,}")
    rows += [
        ("bytes of anything else", f"{MAX_BYTES:,}"),
        ("characters of a name or an id", "32"),
        ("characters of a word or a seed", "64"),
        ("characters of text", "1,000; the `SayLimit` of a simulation may be lower"),
        ("parts of a robot", str(rules.MAX_PARTS)),
        ("sensors of a robot", str(rules.MAX_SENSORS)),
        ("rays of a lidar", f"{rules.MAX_RAYS:,}"),
        (
            "rays per simulated second of an agent's sensors, at pace realtime",
            f"{defaults.AGENT_RAYS:,}, or what `iw-server --agent-rays` says; a wedge counts as 2 rays, a sonar as 10, "
            "with Crosstalk as 25",
        ),
        (
            "rays per simulated second of all sensors, at pace realtime",
            f"{defaults.WORLD_RAYS:,}, or what `--world-rays` says",
        ),
        ("bytes of the readings of an agent", "786,432, counting 512 for a sensor and 32 more for a ray"),
        ("seconds in which a `load` is answered", f"{defaults.LOAD_TIME:g}"),
        ("bodies of a crew", str(rules.MAX_CREW)),
        ("absolute value of X and Y", "10,000 m"),
        ("whole numbers", "2^53 - 1"),
    ]
    return _table(("What", "Maximum"), rows)


def _access() -> str:
    rows = ((f"`{CHANNELS[name].key}`", *(roles.get(role, "") for role in LAB_ROLES)) for name, roles in ACCESS.items())
    text = prose.ACCESS.format(overseers=", ".join(role for role in LAB_ROLES if role in OVERSEES))
    return text + _table(("Key", *LAB_ROLES), rows)


def _codes(meanings: Mapping[str, str]) -> str:
    return _table(("Code", "Meaning"), ((f"`{code}`", text) for code, text in meanings.items()))


def _verbs() -> str:
    rows = []
    for verb, cls in VERB_CLASSES.items():
        ros = codes.ROS_VERB[verb]
        rows.append(
            (
                f"`ctl/{verb}{'/<agent>' if verb in AGENT_VERBS else ''}`",
                _linked((cls,)),
                f"`{ros.service}`" if ros.service else "",
                ros.how,
            )
        )
    for key, ros in codes.ROS_KEY.items():
        rows.append((f"`{CHANNELS[key].key}`", "", f"`{ros.service}`", ros.how))
    return _table(("Key", "Message", "ROS service", "How"), rows)


def _default(member: Member) -> str:
    if member.required:
        return "**required**"
    return _default_text(member.default)


def _default_text(default: Any) -> str:
    if default is None or default == () or default is NODEFAULT:
        return ""
    if isinstance(default, bool):
        return "true" if default else "false"
    if isinstance(default, tuple):
        return " ".join(number_text(one) for one in default)
    return number_text(default) if isinstance(default, int | float) else str(default)


def _field(member: Member, text: str) -> tuple[str, str, str, str]:
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
    if member.form in {Form.LIST, Form.RECORDS}:
        kind = f"a list of: {kind}"
    elif member.form is Form.CONTENT:
        kind = f"{kind}; in XML the text of the element"
    elif member.form is Form.ELEMENT:
        kind = f"{kind}; in XML an element"
    if member.max_count is not None:
        kind += f", at most {member.max_count}"
    return f"`{member.wire}`", kind.replace("<", "`<").replace(">", ">`"), _default(member), text


def _message(cls: type[Record], title: str) -> str:
    shape = shape_of(cls)
    doc = " ".join((cls.__doc__ or "").split())
    root = f" Its XML root is `<{shape.root}>`." if cls is OperatorSay else ""
    docs = field_docs(cls)
    rows = [_field(member, docs[member.name]) for member in shape.members]
    fields = _table(("Field", "Type", "Default", "Meaning"), rows) if rows else "No fields.\n"
    return f"### {title}\n\n{doc}{root}\n\n{fields}\n"


def _file_records() -> list[type[FileRecord]]:
    """Return the records of files, with complete lines first."""
    declared = [
        cls
        for cls in vars(file_records).values()
        if isinstance(cls, type) and issubclass(cls, FileRecord) and cls is not FileRecord
    ]
    return [*LINES, *(cls for cls in declared if cls not in LINES)]


def _kind(kind: inspect.Type) -> str:
    """Return the type of a field of a file's record, in words, with links."""
    scalar = scalar_of(kind)
    if scalar is not None:
        return expected(scalar)
    match kind:
        case inspect.Metadata():
            return _kind(kind.type)
        case inspect.StructType():
            name = next((name for name, cls in NAMES.items() if cls is kind.cls), kind.cls.__name__)
            return f"[{name}](#{name.lower()})"
        case inspect.DictType():
            return f"an object, for each name: {_kind(kind.value_type)}"
        case inspect.VarTupleType():
            return f"a list of: {_kind(kind.item_type)}"
        case inspect.TupleType():
            return f"a list of {len(kind.item_types)}: {_kind(kind.item_types[0])}"
        case inspect.UnionType():
            return ", ".join(_kind(one) for one in kind.types if not isinstance(one, inspect.NoneType))
    raise TypeError(f"no words for {kind}")


def _message_of_a_file(cls: type[FileRecord]) -> str:
    info = inspect.type_info(cls)
    if not isinstance(info, inspect.StructType):
        raise TypeError(f"expected a struct, got {cls}")
    docs = field_docs(cls)
    rows = [
        (
            f"`{field.encode_name}`", _kind(field.type),
            "**required**" if field.required else _default_text(field.default), docs[field.name],
        )
        for field in info.fields
    ]  # fmt: skip
    if info.tag_field is not None:
        rows.insert(0, (f"`{info.tag_field}`", str(info.tag), "**required**", "Kind of the change."))
    fields = _table(("Field", "Type", "Default", "Meaning"), rows) if rows else "No fields.\n"
    return f"### {cls.__name__}\n\n{' '.join((cls.__doc__ or '').split())}\n\n{fields}\n"


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
    head = prose.HEAD.format(name=EXPECTED, reserved=", ".join(f"`{name}`" for name in sorted(RESERVED)))
    keys = _table(
        ("Key", "Writer", "Kind", "Priority", "How often", "Message", "Reply", "Error reply"),
        map(_row, CHANNELS.values()),
    )
    parts = [
        head, "\n", keys, _notes(), "\n", _access(), "\n", _schemas(), "## Limits\n\n", _limits(),
        "\n## Codes\n\n### Codes of Refused\n\n", _codes({str(code): text for code, text in codes.REFUSED.items()}),
        "\n### Codes of Error\n\n", _codes({str(code): text for code, text in codes.ERROR.items()}),
        "\n### Codes of Event\n\n", _codes({str(code): text for code, text in codes.EVENT.items()}),
        "\n### States of the motors\n\n`State` in Measures, Power and Entity.\n\n",
        _codes({str(code): text for code, text in codes.MOTOR_STATE.items()}),
        "\n### Codes of Result\n\n",
        _table(
            ("Code", "Meaning", "ROS `Result`"),
            ((f"`{code}`", text, codes.ROS_RESULT[code]) for code, text in codes.RESULT.items()),
        ),
        "\n## Control verbs and their ROS `simulation_interfaces` counterparts\n\n", _verbs(),
        "\n## Messages\n\n",
        *(_message(cls, name) for name, cls in NAMES.items() if cls not in {Lab, Map, Scene}),
        "## Files for people\n\nMaps, robots, scenes and labs are XML files, in which comments and indentation ",
        "are allowed. A robot file is a [Robot](#robot) with `Format`.\n\n",
        *(_message(cls, _name(cls)) for cls in (Map, Scene, Lab)),
        prose.LOGS, *(_message_of_a_file(cls) for cls in _file_records()),
        "## Records used in messages and files\n\n", *(_message(cls, cls.__name__) for cls in _records()),
    ]  # fmt: skip
    return "".join(parts).rstrip("\n") + "\n"
