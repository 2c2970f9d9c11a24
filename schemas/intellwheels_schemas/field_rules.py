"""The rules of `rules`, which span fields, as JSON Schema and as Schematron, as far as each can express them.

`schema_gaps` lists what they cannot.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from intellwheels_schemas.lab_rules import LAB_ROLES, NAMES_AGENTS, NO_AGENTS
from intellwheels_schemas.messages import (
    Compare,
    CrewJoin,
    LabRole,
    LidarReading,
    Load,
    May,
    Obstacle,
    Pose,
    Record,
    Robot,
    Spawn,
    Varied,
    Wall,
    Zone,
)
from intellwheels_schemas.rules import FILE_LACKS, MAX_PARTS, MAX_SENSORS, MIND_FIELDS, SENSOR_RECORDS, values_of
from intellwheels_schemas.shapes import Form, Member, shape_of

Schema = dict[str, Any]

_ONE_PART: Final = ("Length", "Width", "Center", "Top")


def _wires(cls: type[Record], names: tuple[str, ...]) -> list[str]:
    return [member.wire for member in shape_of(cls).members if member.name in names]


def _in_order(roles: frozenset[LabRole]) -> list[str]:
    return [role for role in LAB_ROLES if role in roles]


_KINDS: Final = _wires(Robot, tuple(SENSOR_RECORDS))

# ---------------------------------------------------------------- JSON Schema


def _if(condition: Schema, then: Schema, otherwise: Schema | None = None) -> Schema:
    found = {"if": condition, "then": then}
    return found if otherwise is None else {**found, "else": otherwise}


def _absent(*wires: str) -> Schema:
    return {"properties": dict.fromkeys(wires, False)}


def _is(wire: str, value: str) -> Schema:
    """Return the schema of an object whose field has a value and is there."""
    return {"properties": {wire: {"const": value}}, "required": [wire]}


def _unless_default(member: Member) -> Any:
    if member.default is None:
        return False
    return {"maxItems": 0} if member.default == () else {"const": member.default}


def _robot() -> list[Schema]:
    foreign = [member for member in shape_of(Robot).members if member.name not in MIND_FIELDS]
    form = _if(
        {"properties": {"Part": {"minItems": 1}}, "required": ["Part"]},
        _absent(*_ONE_PART),
        {"required": ["Length", "Width"]},
    )
    simulated = {kind: {"items": {"properties": {"Source": {"const": "simulated"}}}} for kind in _KINDS}
    lacks = _absent(*(wire for wire in _wires(Robot, FILE_LACKS) if wire != "Role"))
    lacks["properties"]["Role"] = {"const": "both"}
    return [
        _if(
            _is("Role", "mind"), {"properties": {member.wire: _unless_default(member) for member in foreign}}, form
        ),
        _if({"required": ["Format"]}, lacks),
        _if(_is("Type", "real"), {}, {"properties": simulated}),
    ]  # fmt: skip


def _lidar() -> list[Schema]:
    ok, other = {"const": "ok"}, {"not": {"const": "ok"}}
    some = {"minItems": 1}
    return [
        _if({"properties": {"Statuses": {"items": ok}}}, {"properties": {"Ranges": {"items": {"type": "number"}}}}),
        _if({"properties": {"Statuses": {"items": other}}}, {"properties": {"Ranges": {"items": {"type": "null"}}}}),
        _if({"properties": {"Ranges": some}, "required": ["Ranges"]},
            {"properties": {"Statuses": some}, "required": ["Statuses"]},
            {"properties": {"Statuses": {"maxItems": 0}}}),
    ]  # fmt: skip


def _reading(cls: type[Record]) -> list[Schema]:
    wires = [wire for _, wire in values_of(cls)]
    return [_if({"properties": {"Status": {"const": "ok"}}}, {"required": wires}, _absent(*wires))]


def _corners(least: int) -> Schema:
    return {"properties": {"Corner": {"minItems": least}}, "required": ["Corner"]}


_SIGNLESS: Final = {"minimum": 0}

_JSON: Final[dict[type[Record], list[Schema]]] = {
    Robot: _robot(),
    LidarReading: _lidar(),
    **{kind.reading: _reading(kind.reading) for kind in SENSOR_RECORDS.values() if values_of(kind.reading)},
    Pose: [{"properties": {"Covariance": {
        "anyOf": [{"minItems": 6, "maxItems": 6}, {"maxItems": 0}],
        "prefixItems": [_SIGNLESS, True, True, _SIGNLESS, True, _SIGNLESS],
    }}}],
    Load: [{"oneOf": [{"required": ["Name"]}, {"required": ["Map"]}]}],
    Spawn: [{"properties": {"Robot": {"properties": {
        "Role": {"const": "both"}, "Type": {"const": "simulated"},
    }}}}],
    CrewJoin: [{"properties": {"Robot": {"items": {"required": ["Name"]}}}}],
    Wall: [_if({"required": ["Thickness"]}, _corners(2), _corners(3))],
    Obstacle: [_corners(3)],
    Zone: [_corners(3)],
    May: [
        _if({"properties": {"Role": {"enum": _in_order(NAMES_AGENTS)}}},
            {"properties": {"Agents": {"minItems": 1}}, "required": ["Agents"]}),
        _if({"properties": {"Role": {"enum": _in_order(NO_AGENTS)}}},
            {"properties": {"Agents": {"maxItems": 0}}}),
        _if({"properties": {"Role": {"not": {"const": "operator"}}}}, {"properties": {"Verbs": {"maxItems": 0}}}),
    ],
    Varied: [{"properties": {"Level": {"minItems": 1}}, "required": ["Level"]}],
    Compare: [_if(_is("Expect", "collision-free"), _absent("Second"), {"required": ["Second"]})],
}  # fmt: skip


def json_rules(cls: type[Record]) -> list[Schema]:
    """Return the schemas that an object of a class must also fulfil."""
    return _JSON.get(cls, [])


# ---------------------------------------------------------------- Schematron


# The spaces between the items of a list, which are one more.
_ITEMS: Final = "string-length(normalize-space({0})) - string-length(translate(normalize-space({0}), ' ', ''))"


class Assertion(NamedTuple):
    """A rule of an XML document.

    Attributes:
        context: XPath 1.0 pattern of the elements that it is about.
        test: XPath 1.0 expression that must be true there.
        text: What is expected, in words.
    """

    context: str
    test: str
    text: str


def _exponent(*attributes: str) -> str:
    # XPath 1.0 reads no numbers with an exponent, so the rule does not judge them.
    return " or ".join(f"contains(translate({name}, 'E', 'e'), 'e')" for name in attributes)


def _less(context: str, low: str, high: str) -> Assertion:
    test = f"number({low}) &lt; number({high}) or {_exponent(low, high)}"
    return Assertion(f"{context}[{low}][{high}]", test, f"{low} must be less than {high}")


def _may(roles: frozenset[LabRole]) -> str:
    tests = [f"@Role = '{role}'" for role in _in_order(roles)]
    return f"May[{' or '.join(tests)}]"


def _robot_assertions() -> list[Assertion]:
    mind = [member for member in shape_of(Robot).members if member.name not in MIND_FIELDS]
    children = [m.wire for m in mind if m.form in {Form.RECORD, Form.RECORDS}]
    others = [m for m in mind if m.wire not in children]
    bare = [f"not({wire})" for wire in children]
    bare += [f"not(@{member.wire})" if member.default is None else _is_default(member) for member in others]
    sensors = [f"Robot/{kind}" for kind in _KINDS]
    count = " + ".join(f"count({kind})" for kind in _KINDS)
    one_part = " or ".join(f"@{wire}" for wire in _ONE_PART)
    lacks = " or ".join(f"@{wire}" for wire in _wires(Robot, FILE_LACKS) if wire != "Role")
    ids = " | ".join(f"../{kind}/@Id" for kind in _KINDS)
    return [
        Assertion("Robot[@Role = 'mind']", " and ".join(bare), "a mind has no fields of a body"),
        Assertion("Robot[not(@Role = 'mind')]", f"(Part and not({one_part})) or (not(Part) and @Length and @Width)",
                  "either Part, or Length and Width"),
        Assertion("Robot[@Format]", f"not({lacks}) and (not(@Role) or @Role = 'both')",
                  "a file has no Name, Role, Instance or Place"),
        Assertion("Robot", f"count(Part) &lt;= {MAX_PARTS}", f"at most {MAX_PARTS} Part"),
        Assertion("Robot", f"{count} &lt;= {MAX_SENSORS}", f"at most {MAX_SENSORS} sensors"),
        Assertion(" | ".join(sensors), f"count(({ids})[. = current()/@Id]) = 1", "each Id once in a robot"),
        Assertion(" | ".join(f"Robot[not(@Type = 'real')]/{kind}" for kind in _KINDS),
                  "not(@Source) or @Source = 'simulated'", "Source is simulated for a simulated robot"),
        *(_less(f"Robot/{kind}", "@MinRange", "@MaxRange") for kind in _KINDS),
        _less("Robot/Part", "@Bottom", "@Top"),
        Assertion("Spawn/Robot", "(not(@Role) or @Role = 'both') and not(@Type = 'real')",
                  "a simulated robot of role both"),
    ]  # fmt: skip


def _is_default(member: Member) -> str:
    """Return the test that an attribute is absent or has its default."""
    default, name = member.default, f"@{member.wire}"
    if isinstance(default, bool):
        return f"(not({name}) or {name} = '{'true' if default else 'false'}')"
    if isinstance(default, int | float):
        return f"(not({name}) or number({name}) = {default})"
    return f"(not({name}) or {name} = '{default}')"


def _reading_assertions() -> list[Assertion]:
    found = []
    for name, (_, reading) in SENSOR_RECORDS.items():
        context = f"Sensors/{_wires(Robot, (name,))[0]}"
        wires = [wire for _, wire in values_of(reading)]
        if wires:
            there = " and ".join(f"@{wire}" for wire in wires)
            nothing = " and ".join(f"not(@{wire})" for wire in wires)
            test = f"((not(@Status) or @Status = 'ok') and {there}) or (@Status and @Status != 'ok' and {nothing})"
            found.append(Assertion(context, test, "values where Status is ok, and only there"))
    ranges, statuses = _ITEMS.format("@Ranges"), _ITEMS.format("@Statuses")
    same = f"{ranges} = {statuses} and boolean(normalize-space(@Ranges)) = boolean(normalize-space(@Statuses))"
    found.append(Assertion("Sensors/Lidar", same, "as many Statuses as Ranges"))
    return found


def _crew(root: str) -> list[Assertion]:
    alone = Assertion(f"{root}[@Part][not(@Parts)]", "number(@Part) = 0", "Part must be less than the default Parts")
    return [_less(root, "@Part", "@Parts"), alone]


_ROWS: Final = (("Compare", "First"), ("Compare", "Second"), ("Umbmark", "Left"), ("Umbmark", "Right"))


def _file_assertions() -> list[Assertion]:
    covariance = _ITEMS.format("@Covariance")
    return [
        Assertion("Pose", f"not(normalize-space(@Covariance)) or {covariance} = 5", "6 numbers, or none"),
        *_crew("CrewActions"), *_crew("CrewMeasures"),
        Assertion("CrewJoin/Robot", "@Name", "the Name of the agent"),
        Assertion("CrewJoin/Robot", "count(../Robot[@Name = current()/@Name]) = 1", "each agent once"),
        Assertion("CrewActions/Actions", "count(../Actions[@Agent = current()/@Agent]) = 1", "each agent once"),
        Assertion("Load", "boolean(@Name) != boolean(Map)", "either Name or Map"),
        Assertion("Wall", "count(Corner) &gt;= 3 or (@Thickness and count(Corner) = 2)",
                  "at least 3 corners, or 2 with Thickness"),
        _less("Wall", "@Bottom", "@Height"),
        Assertion("Wall[@Bottom][not(@Height)]", f"number(@Bottom) &lt; 2.5 or {_exponent('@Bottom')}",
                  "@Bottom must be less than the default Height"),
        Assertion("Obstacle | Zone", "count(Corner) &gt;= 3", "at least 3 corners"),
        _less("Obstacle", "@Bottom", "@Top"),
        Assertion("Lab/Identity", "count(../Identity[@Name = current()/@Name]) = 1", "each Name once"),
        Assertion(_may(NAMES_AGENTS), "normalize-space(@Agents)",
                  "the Agents of the role"),
        Assertion(_may(NO_AGENTS), "not(normalize-space(@Agents))",
                  "no Agents, as the role is for the whole world"),
        Assertion("May[@Role != 'operator']", "not(normalize-space(@Verbs))", "Verbs of an operator only"),
        Assertion("Scene/Cast", "count(../Cast[@Name = current()/@Name]) = 1", "each Name once in a cast"),
        Assertion("Scene/Cast", "boolean(@Mind) != boolean(@Command)", "either Mind or Command"),
        Assertion("Scene/Cast[@Command]", "not(@Robot) or //Bridge[@Agent = current()/@Name]",
                  "no Robot with a Command"),
        Assertion("Scene/Cast[@Command]", "not(Option) or //Bridge[@Agent = current()/@Name]",
                  "no Option with a Command"),
        Assertion("Scene/Cast[@Folder]", "@Command", "Folder with a Command only"),
        Assertion("Cast/Option", "count(../Option[@Name = current()/@Name]) = 1", "each option once"),
        Assertion("Scene/Bridge", "../Cast[@Name = current()/@Agent]", "Agent is in the cast"),
        Assertion("Scene/Bridge", "count(../Bridge[@Agent = current()/@Agent]) = 1", "one bridge for an agent"),
        Assertion("Scene/End/Reach", "../../Cast[@Name = current()/@Agent]", "Agent is in the cast"),
        Assertion("Experiment", "../Cast[@Name = current()/@Subject] or Factor/Level/Cast[@Name = current()/@Subject]",
                  "Subject is in the cast"),
        Assertion("Uniform", "count(@Agent | @Place | @Obstacle) = 1", "one of Agent, Place and Obstacle"),
        Assertion("Uniform[@Place]", "@Name = 'X' or @Name = 'Y' or @Name = 'HeadingDeg'", "X, Y or HeadingDeg"),
        Assertion("Uniform[@Obstacle]", "@Name = 'X' or @Name = 'Y'", "X or Y"),
        Assertion("Uniform[@Agent]", "//Cast[@Name = current()/@Agent]", "Agent is in the cast"),
        Assertion(
            "Uniform",
            "count(../Uniform[@Name = current()/@Name and concat(@Agent, '/', @Place, '/', @Obstacle)"
            " = concat(current()/@Agent, '/', current()/@Place, '/', current()/@Obstacle)]) = 1",
            "each number once",
        ),
        Assertion("Uniform[@Follows]", "@Agent and @Follows != @Name", "another option of an Agent"),
        _less("Uniform", "@Low", "@High"),
        Assertion("Factor", "Level", "at least one Level"),
        Assertion("Factor", "count(../Factor[@Name = current()/@Name]) = 1", "each factor once"),
        Assertion("Factor/Level", "count(../Level[@Name = current()/@Name]) = 1", "each level once"),
        Assertion("Compare", "boolean(@Second) != (@Expect = 'collision-free')",
                  "a Second, except for collision-free"),
        # The name of a row joins a level of each factor. XPath 1.0 can say which rows there are only for one factor.
        *(
            Assertion(
                f"Experiment[count(Factor) = 1]/{element}",
                f"not(@{side}) or ../Factor/Level[@Name = current()/@{side}]",
                f"{side} is a row",
            )
            for element, side in _ROWS
        ),
        Assertion("Umbmark", "@Left != @Right", "two rows"),
    ]  # fmt: skip


def _single_children(classes: dict[str, type[Record]]) -> list[Assertion]:
    """Return the rules that children that are not a list occur once, and that they are there if required.

    XML Schema 1.0 cannot say so of a class that also has a list.
    """
    found = []
    for context, cls in classes.items():
        members = shape_of(cls).members
        if any(member.form is Form.RECORDS for member in members):
            for member in members:
                if member.form in {Form.RECORD, Form.ELEMENT}:
                    test = f"count({member.wire}) {'= 1' if member.required else '&lt;= 1'}"
                    found.append(Assertion(context, test, f"one {member.wire}"))
    return found


def _numbers(classes: dict[str, type[Record]]) -> list[Assertion]:
    """Return the rules that numbers have no spaces around them, which XML Schema removes before it looks."""
    found = []
    for context, cls in classes.items():
        wires = [
            m.wire for m in shape_of(cls).members
            if m.form is Form.ATTRIBUTE and m.scalar is not None and m.scalar.kind in {"integer", "number", "truth"}
        ]  # fmt: skip
        if wires:
            test = " and ".join(f"not(contains(@{wire}, ' '))" for wire in wires)
            found.append(Assertion(context, test, "no spaces around a number"))
    return found


def assertions(contexts: dict[str, type[Record]]) -> list[Assertion]:
    """Return all rules of XML documents.

    Args:
        contexts: The classes of elements, by a pattern that finds them.
    """
    return [
        *_single_children(contexts), *_numbers(contexts), *_robot_assertions(), *_reading_assertions(),
        *_file_assertions(),
    ]  # fmt: skip
