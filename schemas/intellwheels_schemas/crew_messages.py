"""Puts messages of single agents together into those of a crew, and takes them apart. Pure.

What each agent sends or gets is encoded once, as if it were alone. Here its name is added, and the bytes are joined.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate
from operator import attrgetter, ne
from typing import Annotated, Any, Final, Literal, NamedTuple

import msgspec
from lxml import etree

from intellwheels_schemas import elements, rules
from intellwheels_schemas.codec import LIMITS, MAX_BYTES, Encoding, decode, from_plain, parse_json, repeats_nothing
from intellwheels_schemas.errors import WireError, wrong_value
from intellwheels_schemas.explain import Repeated, shown, too_long
from intellwheels_schemas.messages import (
    Actions,
    AgentActions,
    AgentMeasures,
    CrewActions,
    CrewJoin,
    CrewMeasures,
    ElementText,
    Goal,
    PartCount,
    PartNumber,
    Power,
    SentSeq,
    SentTick,
    Word,
)
from intellwheels_schemas.names import is_name

CrewKind = Literal["Actions", "Measures", "Leave"]

PART_BYTES: Final = 48_000
"""Size of a part: messages above 60 kB delay a healthy reader a hundredfold."""
JOIN_BYTES: Final = LIMITS[CrewJoin] * 3 // 4
"""Bytes of the robots in one request to join, which has some more."""


# ---------------------------------------------------------------- out


def for_crew(data: bytes, agent: str, encoding: Encoding) -> bytes:
    """Return an encoded message of one agent, not an empty one, with its name, as a message of its crew has it."""
    if encoding is Encoding.JSON:
        return b'%s,"Agent":"%s"}' % (data[:-1], agent.encode())
    # The first > ends the first tag, as it is escaped in attributes.
    end = data.index(b">")
    end -= data[end - 1 : end] == b"/"
    return b'%s Agent="%s"%s' % (data[:end], agent.encode(), data[end:])


def crew_messages(kind: CrewKind, crew: str, items: Sequence[bytes], encoding: Encoding) -> list[bytes]:
    """Return the encoded `CrewActions`, `CrewMeasures` or `CrewLeave` with these items, in parts of at most 48 kB.

    All that 250 agents need to leave is one part.

    Args:
        kind: What the items are.
        crew: Name of the crew.
        items: Encoded messages of agents, from `for_crew`. Without any, nothing is returned.
        encoding: Their encoding.
    """
    parts = list(_parts(items))
    count = len(parts)
    if encoding is Encoding.JSON:
        return [
            b"{%s,%s:[%s]}" % (_head_json(crew, number, count), b'"%s"' % kind.encode(), b",".join(part))
            for number, part in enumerate(parts)
        ]
    root = f"Crew{kind}".encode()
    return [
        b"<%s %s>%s</%s>" % (root, _head_xml(crew, number, count), b"".join(part), root)
        for number, part in enumerate(parts)
    ]


def _head_json(crew: str, part: int, parts: int) -> bytes:
    number = f',"Part":{part}' if part else ""
    return f'"Crew":"{crew}"{number}{f",{chr(34)}Parts{chr(34)}:{parts}" if parts != 1 else ""}'.encode()


def _head_xml(crew: str, part: int, parts: int) -> bytes:
    number = f' Part="{part}"' if part else ""
    return f'Crew="{crew}"{number}{f" Parts={chr(34)}{parts}{chr(34)}" if parts != 1 else ""}'.encode()


def join_parts(items: Sequence[bytes]) -> list[Sequence[bytes]]:
    """Return encoded robots in as few groups as fit into a `CrewJoin` each."""
    return list(_parts(items, JOIN_BYTES))


def crew_join(crew: str, instance: str, robots: Sequence[bytes], encoding: Encoding) -> bytes:
    """Return the encoded `CrewJoin` with these encoded robots."""
    if encoding is Encoding.JSON:
        head = f'"Crew":"{crew}","Instance":"{instance}"'.encode()
        return b'{%s,"Robot":[%s]}' % (head, b",".join(robots))
    return f'<CrewJoin Crew="{crew}" Instance="{instance}">'.encode() + b"".join(robots) + b"</CrewJoin>"


def _parts(items: Sequence[bytes], limit: int = PART_BYTES) -> Iterator[Sequence[bytes]]:
    ends = list(accumulate(len(item) + 1 for item in items))  # each item has a comma behind it, which the last lacks
    first = before = 0
    while first < len(items):
        end = max(bisect_right(ends, before + limit + 1, first), first + 1)
        yield items[first:end]
        first, before = end, ends[end - 1]


def alone(actions: Actions) -> Actions:
    """Return the actions of an agent of a crew as if it were in none."""
    if not isinstance(actions, AgentActions):
        return actions
    return Actions(**{name: getattr(actions, name) for name in Actions.__struct_fields__})


# ---------------------------------------------------------------- in


class _Agent(msgspec.Struct, rename="pascal"):
    agent: str = ""


class _MeasuresFrame(msgspec.Struct, rename="pascal"):
    part: int = 0
    parts: int = 1
    measures: list[msgspec.Raw] = []


_read_frame: Final = msgspec.json.Decoder(_MeasuresFrame).decode
_read_agent: Final = msgspec.json.Decoder(_Agent).decode
_MEASURES: Final = CrewMeasures.__name__
_ACTIONS: Final = CrewActions.__name__
_ITEM: Final = AgentActions.__name__


class CrewPart(NamedTuple):
    """A part of the measures of a crew.

    Attributes:
        part, parts: Which part it is, counted from 0, and how many there are.
        measures: The encoded `AgentMeasures` of each agent, by its name.
    """

    part: int
    parts: int
    measures: dict[str, bytes]


def split_measures(data: bytes, encoding: Encoding) -> CrewPart:
    """Take `CrewMeasures` apart, without reading what is in it. Each piece is a document that `decode` reads.

    Raises:
        WireError: It is no `CrewMeasures`.
    """
    if encoding is Encoding.JSON:
        try:
            frame = _read_frame(data)
            return CrewPart(frame.part, frame.parts, {_read_agent(raw).agent: bytes(raw) for raw in frame.measures})
        except (msgspec.MsgspecError, ValueError, RecursionError):
            decode(CrewMeasures, data, encoding, strict=False)  # says what is wrong
            raise WireError("value", f"{_MEASURES}: expected measures of a crew, got another document") from None
    root = elements.parse(data, _MEASURES)
    if root.tag != _MEASURES:
        raise WireError("malformed", f"{_MEASURES}: expected <{_MEASURES}>, got <{str(root.tag)[:40]}>", _MEASURES)
    part, parts = (int(text) if text.isdecimal() else 0 for text in (root.get("Part", "0"), root.get("Parts", "1")))
    found = {}
    for child in root:
        if child.tag == "Measures":
            child.tag = AgentMeasures.__name__
            found[child.get("Agent", "")] = etree.tostring(child, with_tail=False)
    return CrewPart(part, parts, found)


class _KnownActions(AgentActions, frozen=True, kw_only=True):
    """`AgentActions` whose run, session and name are compared with known ones, so that no pattern is searched in them.

    All fields stand here again in the order in which they are written.
    """

    run: str | None = None
    session: str | None = None
    tick: SentTick | None = None
    seq: SentSeq | None = None
    left_motor: Power | None = None
    right_motor: Power | None = None
    mode: Word | None = None
    leave: bool = False
    goal: Goal | None = None
    say: ElementText | None = None
    agent: str


class _KnownCrewActions(CrewActions, frozen=True, kw_only=True):
    """`CrewActions` with such items."""

    crew: str
    part: PartNumber = 0
    parts: PartCount = 1
    actions: Annotated[tuple[_KnownActions, ...], msgspec.Meta(max_length=rules.MAX_CREW)] = ()


_read_known: Final = msgspec.json.Decoder(_KnownCrewActions).decode
_FACTS: Final = attrgetter("agent", "session", "run", "tick", "leave", "say")


def read_known_actions(
    crew: str, data: bytes, run: str, tick: int, sessions: Mapping[str, str]
) -> dict[str, AgentActions] | None:
    """Return the actions in JSON `CrewActions` by agent, or None if some of them need to be read with `read_actions`.

    This is quicker, and the result is the same. It is for what nearly all crews send at nearly all ticks: all actions
    answer this tick of this run, no agent leaves, and none says anything.

    Args:
        crew: Name of the crew in the key.
        data: The payload.
        run: The current run.
        tick: The current tick.
        sessions: The session of each agent of the crew.
    """
    if len(data) > LIMITS.get(CrewActions, MAX_BYTES):
        return None
    try:
        message = _read_known(data)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return None
    items = message.actions
    if not items or message.crew != crew or not message.part < message.parts or not repeats_nothing(message, data):
        return None
    agents, found, runs, ticks, leaves, says = zip(*map(_FACTS, items), strict=True)
    if {*runs} != {run} or {*ticks} != {tick} or any(leaves) or {*says} != {None}:
        return None
    actions: dict[str, AgentActions] = dict(zip(agents, items, strict=True))
    if None in found or len(actions) != len(items) or any(map(ne, map(sessions.get, agents), found)):
        return None
    return actions


class WrongItem(NamedTuple):
    """What is wrong with the actions of one agent of a crew; the agent is empty if its name cannot be read."""

    agent: str
    error: WireError


def read_actions(crew: str, data: bytes, encoding: Encoding) -> Sequence[AgentActions | WrongItem]:
    """Return the actions in `CrewActions`. Wrong ones of an agent do not affect those of the others.

    Args:
        crew: Name of the crew in the key.
        data: The payload.
        encoding: Its encoding.

    Raises:
        WireError: The message as a whole is wrong.
    """
    try:
        message = decode(CrewActions, data, encoding)
    except WireError as error:
        if error.code in {"too-long", "too-many"}:
            raise
        return list(_each_by_itself(crew, *_taken_apart(data, encoding)))
    _check_name(message, crew)
    return message.actions


def _check_name(message: CrewActions, crew: str) -> None:
    if message.crew != crew:
        raise wrong_value(f"{_ACTIONS}.Crew", f"{shown(crew)} as in the key", shown(message.crew))


def _each_by_itself(crew: str, rest: Any, items: Sequence[tuple[Any, Any]]) -> Iterator[AgentActions | WrongItem]:
    """Yield each of the actions, or what is wrong with them.

    Args:
        crew: Name of the crew.
        rest: The plain data of the message without its items.
        items: The name in each item, and its plain data or the error in it.

    Raises:
        WireError: The rest is wrong.
    """
    message = from_plain(CrewActions, rest)
    rules.check(message)
    _check_name(message, crew)
    if len(items) > rules.MAX_CREW:
        raise too_long(f"{_ACTIONS}.Actions", rules.MAX_CREW, "of them", len(items))
    seen: set[str] = set()
    for index, (name, item) in enumerate(items):
        where = f"{_ACTIONS}.Actions[{index}]"
        agent = name if isinstance(name, str) and is_name(name) else ""
        try:
            if isinstance(item, WireError):
                raise item
            actions = from_plain(AgentActions, item)
            rules.check(actions)
            if agent in seen:
                raise wrong_value(f"{where}.Agent", "each agent once", f"{shown(agent)} twice")
            seen.add(agent)
            yield actions
        except WireError as wrong:
            text, place = (one.replace(_ITEM, where, 1) for one in (wrong.text, wrong.where))
            yield WrongItem(agent, WireError(wrong.code, text, place))


def _taken_apart(data: bytes, encoding: Encoding) -> tuple[Any, Sequence[tuple[Any, Any]]]:
    """Return the plain data of a message without its items; and the name in each item, and its data or its error."""
    if encoding is Encoding.JSON:
        rest = parse_json(data, _ACTIONS)
        items = rest.get("Actions") if isinstance(rest, dict) else None
        if not isinstance(items, list) or isinstance(rest, Repeated):
            return rest, ()
        return {name: value for name, value in rest.items() if name != "Actions"}, [
            (item.get("Agent") if isinstance(item, dict) else None, item) for item in items
        ]
    root = elements.parse(data, _ACTIONS)
    if root.tag != _ACTIONS:
        raise WireError("malformed", f"{_ACTIONS}: expected <{_ACTIONS}>, got <{str(root.tag)[:40]}>", _ACTIONS)
    found: list[tuple[Any, Any]] = []
    for child in [child for child in root if child.tag == "Actions"]:
        root.remove(child)
        try:
            item: Any = elements.to_plain(child, AgentActions, _ITEM, strict=True)
        except WireError as error:
            item = error
        found.append((child.get("Agent"), item))
    return elements.to_plain(root, CrewActions, _ACTIONS, strict=True), found
