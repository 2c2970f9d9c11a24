"""Writes the measures of many agents as bytes, straight from the samples, without making a message of each.

The bytes are those of `codec.encode(measures(state, agent))`. What is fixed is taken from the codec itself when the set
of bodies changes: nothing here knows how a message looks, except where numbers stand in it. Bodies with a sensor that
is not `written` this way, and real bodies that forward readings, take the way through messages. So does everything as
long as `Measures` has a field that is not in `WRITTEN`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import Map, Measures, Record, Robot, Sensors
from intellwheels_schemas.shapes import shape_of
from intellwheels_server.world.body_set import BodySet
from intellwheels_server.world.hearing import heard_by
from intellwheels_server.world.kernels import measures_text as kernel
from intellwheels_server.world.kernels.arrays import Ints
from intellwheels_server.world.kernels.measures_text import Bytes
from intellwheels_server.world.observations import measures
from intellwheels_server.world.sensors import FittedFields
from intellwheels_server.world.sensors.catalogue import KINDS
from intellwheels_server.world.sensors.kind import Fitted, Kind, Written
from intellwheels_server.world.state import State

WRITTEN: Final = frozenset({"run", "tick", "time", "collision", "contact", "state", "sensors", "message", "user_input"})
"""The fields of `Measures` that are written here."""

_KNOWS_ALL: Final = WRITTEN.issuperset(Measures.__struct_fields__)
_NUMBER: Final = re.compile(rb"[-+.0-9e]+")
_XML_END: Final = b"</Measures>"
_EARLIER: Final = 7  # a tick that stands in readings of which only the form counts
_RUN: Final = "0" * 16
_MOST_LAYOUTS: Final = 4_096


class _Text:
    """Fixed bytes, one behind the other."""

    def __init__(self) -> None:
        self.bytes = bytearray()

    def add(self, text: bytes) -> tuple[int, int]:
        """Add a fragment and return its place."""
        begin = len(self.bytes)
        self.bytes += text
        return begin, len(self.bytes)


class _Layout(NamedTuple):
    """The sensors of a robot, as `kernels.measures_text` takes them; places count from the start of this layout.

    Attributes:
        sensors: int64[sensors, SENSOR_COLUMNS].
        forms: int64[forms].
        steps: int64[steps, 4].
        text: The fixed bytes.
        longest: Most bytes of its readings.
    """

    sensors: Ints
    forms: Ints
    steps: Ints
    text: bytes
    longest: int


class _Bound(NamedTuple):
    """What is fixed while the bodies and the agents stay the same.

    Attributes:
        body_set, agents: Of which it was made.
        way: For each agent, whether the kernel writes its measures.
        readers, sensors, forms, steps, frame, text: As `write_measures` takes them, of the agents that it writes.
        longest: Most bytes of all messages together, without their heads.
        wanting: Places of the agents whose measures may carry the input of a user.
    """

    body_set: BodySet
    agents: Sequence[str]
    way: tuple[bool, ...]
    readers: Ints
    sensors: Ints
    forms: Ints
    steps: Ints
    frame: Ints
    text: Bytes
    longest: int
    wanting: frozenset[int]


class MeasuresWriter:
    """Writes measures in one encoding. What it prepares for a set of bodies is kept until another one comes.

    Args:
        encoding: The encoding.
        named: Whether each message carries the name of its agent, as those of a crew do: then each is an element of
            `CrewMeasures`, not a document.
    """

    def __init__(self, encoding: Encoding, *, named: bool = False) -> None:
        self._xml = encoding is Encoding.XML
        self._encoding = encoding
        self._named = named
        self._frame_text = _Text()
        self._frame = _frame(encoding, self._frame_text)
        self._tail: Bytes = np.frombuffer(b"" if self._xml else b"}", np.uint8)
        self._layouts: dict[str, tuple[Robot, _Layout | None]] = {}
        self._shared: dict[object, _Layout | None] = {}
        self._floor: Map | None = None
        self._bound: _Bound | None = None
        self._out: Bytes = np.empty(0, np.uint8)

    def write(self, state: State, agents: Sequence[str]) -> list[bytes]:
        """Return the measures of agents at this tick, in their order.

        Args:
            state: The world.
            agents: Names of bodies. It is quickest to give the same object again while it holds the same names.

        Raises:
            KeyError: There is no body of such a name.
        """
        bound = self._bound
        if bound is None or bound.body_set is not state.body_set or bound.agents is not agents:
            bound = self._bound = self._bind(state, agents)
        empty = encode(Measures(run=state.run, tick=state.tick, time=state.shown_time), self._encoding)
        head = empty[: -2 if self._xml else -1]
        found = self._written(bound, state, head)
        if not all(bound.way):
            quick = iter(found)
            found = [next(quick) if way else b"" for way in bound.way]
        incomplete: Iterable[int] = bound.wanting if state.user else ()
        if state.heard or state.forwarded or b"" in found:
            incomplete = range(len(agents))
        for at in incomplete:
            found[at] = self._completed(state, agents[at], at in bound.wanting, found[at], head)
        return found

    # ------------------------------------------------------------ at each tick

    def _written(self, bound: _Bound, state: State, head: bytes) -> list[bytes]:
        """Return the messages of the agents that the kernel writes; an empty one where it cannot."""
        count = bound.readers.shape[1]
        if count == 0:
            return []
        room = bound.longest + count * len(head)
        if len(self._out) < room:
            self._out = np.empty(room, np.uint8)
        ends = np.empty(count + 1, np.int64)
        kernel.write_measures(
            state.tick,
            self._xml,
            np.frombuffer(head, np.uint8),
            self._tail,
            bound.readers,
            bound.sensors,
            bound.forms,
            bound.steps,
            bound.frame,
            bound.text,
            state.flags,
            state.numbers,
            state.samples,
            self._out,
            ends,
        )
        places = ends.tolist()
        data = self._out[: places[-1]].tobytes()
        return [data[begin:end] for begin, end in pairwise(places)]

    def _completed(self, state: State, agent: str, wants_user: bool, data: bytes, head: bytes) -> bytes:
        """Return a message with what the kernel does not write."""
        if not data or agent in state.forwarded:
            whole = encode(measures(state, agent), self._encoding)
            return self._with_name(whole, agent) if self._named else whole
        heard = heard_by(state, agent) if state.heard else ()
        user = state.user.get(agent) if wants_user else None
        if not heard and user is None:
            return data
        more = Measures(run=state.run, tick=state.tick, time=state.shown_time, message=heard, user_input=user)
        rest = encode(more, self._encoding)[len(head) :]
        if not self._xml:
            kept = len(data) - len(self._name(agent)) - 1
            return data[:kept] + rest[:-1] + data[kept:]
        if data.endswith(_XML_END):
            return data[: -len(_XML_END)] + rest[1:]
        return data[:-2] + rest

    def _name(self, agent: str) -> bytes:
        """Return the bytes that name an agent."""
        if not self._named:
            return b""
        return (f' Agent="{agent}"' if self._xml else f',"Agent":"{agent}"').encode()

    def _with_name(self, data: bytes, agent: str) -> bytes:
        """Return a message with the name of its agent as its last attribute."""
        at = len(data) - 1
        if self._xml:
            at = data.index(b">")
            at -= data[at - 1 : at] == b"/"
        return data[:at] + self._name(agent) + data[at:]

    # ------------------------------------------------------------ when the bodies change

    def _bind(self, state: State, agents: Sequence[str]) -> _Bound:
        """Prepare for the bodies of a state."""
        body_set = state.body_set
        if state.setup.floor is not self._floor or len(self._shared) > _MOST_LAYOUTS:
            self._floor, self._layouts, self._shared = state.setup.floor, {}, {}
        layouts = [self._layout(body_set, agent) for agent in agents]
        for agent in self._layouts.keys() - set(agents):
            del self._layouts[agent]
        text = _Text()
        text.add(bytes(self._frame_text.bytes))
        joined = _Joined(text)
        readers, longest = [], 0
        for agent, layout in zip(agents, layouts, strict=True):
            if layout is None:
                continue
            index = body_set.index[agent]
            fitting = body_set.plan.fittings[index]
            name = self._name(agent)
            readers.append((index, fitting.begin, fitting.joined, *joined.place(layout), *text.add(name)))
            longest += layout.longest + len(name)
        longest += len(readers) * self._longest_frame()
        return _Bound(
            body_set=body_set,
            agents=agents,
            way=tuple(layout is not None for layout in layouts),
            readers=np.array(readers, np.int64).reshape(-1, kernel.READER_ROWS).T.copy(),
            sensors=_stacked(joined.sensors, kernel.SENSOR_COLUMNS),
            forms=np.concatenate([np.empty(0, np.int64), *joined.forms]),
            steps=_stacked(joined.steps, 4),
            frame=self._frame,
            text=np.frombuffer(bytes(text.bytes), np.uint8),
            longest=longest,
            wanting=frozenset(at for at, agent in enumerate(agents) if body_set.models[agent].wants_user),
        )

    def _longest_frame(self) -> int:
        size = self._frame[:, 1] - self._frame[:, 0]
        return int(size[: kernel.MARKS].sum() + size[kernel.MARKS :].max()) + len(self._tail)

    def _layout(self, body_set: BodySet, agent: str) -> _Layout | None:
        """Return the layout of a body, or None if the kernel cannot write its measures."""
        if not _KNOWS_ALL:
            return None
        robot, known = body_set.models[agent].robot, self._layouts.get(agent)
        if known is not None and known[0] is robot:
            return known[1]
        fields = body_set.plan.fittings[body_set.index[agent]].fields
        key = tuple(place.sensor.declaration for _, places in fields for place in places)
        if key not in self._shared:
            self._shared[key] = _layout_of(fields, self._encoding)
        layout = self._shared[key]
        self._layouts[agent] = robot, layout
        return layout


class _Joined:
    """Layouts, each taken in once, one behind the other."""

    def __init__(self, text: _Text) -> None:
        self.sensors: list[Ints] = []
        self.forms: list[Ints] = []
        self.steps: list[Ints] = []
        self._text = text
        self._counts = [0, 0, 0]
        self._known: dict[int, tuple[int, int]] = {}

    def place(self, layout: _Layout) -> tuple[int, int]:
        """Return the first sensor of a layout and the end."""
        known = self._known.get(id(layout))
        if known is not None:
            return known
        first, forms, steps = self._counts
        begin, _ = self._text.add(layout.text)
        sensors = layout.sensors.copy()
        sensors[:, kernel.LIST_BEGIN : kernel.LIST_END + 1] += begin
        sensors[:, kernel.FORM] += forms
        moved = layout.steps.copy()
        moved[:, kernel.STEP_BEGIN : kernel.STEP_END + 1] += begin
        self.sensors.append(sensors)
        self.forms.append(layout.forms + steps)
        self.steps.append(moved)
        self._counts = [first + len(sensors), forms + len(layout.forms), steps + len(moved)]
        self._known[id(layout)] = first, self._counts[0]
        return self._known[id(layout)]


def _stacked(blocks: Iterable[Ints], columns: int) -> Ints:
    return np.concatenate([np.empty((0, columns), np.int64), *blocks])


def _frame(encoding: Encoding, text: _Text) -> Ints:
    """Return the frame of messages in an encoding, with its bytes in `text`."""
    xml = encoding is Encoding.XML
    fragments = (
        (b"><Sensors>", b"</Sensors>" + _XML_END, b"", b"", b"", b"/>")
        if xml
        else (b',"Sensors":{', b"}", b"]", b",", b",", b"")
    )
    places = [text.add(fragment) for fragment in fragments]
    end = -2 if xml else -1
    head = len(encode(Measures(run=_RUN, tick=0, time=0.0), encoding)[:end])
    for state in kernel.STATES:
        for contact in (False, True):
            for collision in (False, True):
                marked = Measures(run=_RUN, tick=0, time=0.0, collision=collision, contact=contact, state=state)
                places.append(text.add(encode(marked, encoding)[head:end]))
    return np.array(places, np.int64)


def _layout_of(fields: FittedFields, encoding: Encoding) -> _Layout | None:
    """Return the layout of sensors, by the fields that list them; None if there is one that must be a reading."""
    text, longest = _Text(), 0
    rows: list[list[int]] = []
    forms: list[int] = []
    steps: list[tuple[int, int, int, int]] = []
    for number, (field, places) in enumerate(fields):
        opening = b""
        for place in places:
            kind = KINDS[type(place.sensor.declaration)]
            written = kind.written(place.sensor)
            if written is None:
                return None
            first_form, most = len(forms), 0
            for code in range(max(written.codes, 1)):
                for late in (False, True):
                    forms.append(len(steps))
                    record = _example(kind, written, place.sensor, code, late)
                    opening, item = _cut(field, record, encoding)
                    new = _steps(record, item, written, text, encoding)
                    steps.extend(new)
                    most = max(most, len(item) + kernel.LONGEST_NUMBER * len(new))
            row = [0] * kernel.SENSOR_COLUMNS
            row[kernel.FIRST], row[kernel.WIDTH], row[kernel.DEPTH] = place.first, place.width, place.depth
            row[kernel.EVERY], row[kernel.LATENCY], row[kernel.PHASE] = place.every, place.latency, place.phase
            row[kernel.LIST], row[kernel.CODES], row[kernel.LOWEST] = number, written.codes, written.lowest
            row[kernel.LIST_BEGIN], row[kernel.LIST_END] = text.add(opening)
            row[kernel.FORM] = first_form
            rows.append(row)
            longest += most + len(opening) + 3  # what closes and separates lists
    return _Layout(
        sensors=np.array(rows, np.int64).reshape(-1, kernel.SENSOR_COLUMNS),
        forms=np.array(forms, np.int64),
        steps=np.array(steps, np.int64).reshape(-1, 4),
        text=bytes(text.bytes),
        longest=longest,
    )


def _example(kind: Kind, written: Written, sensor: Fitted, code: int, late: bool) -> Record:
    """Return a reading of a code, with zeros as its numbers."""
    codes = [float(code + written.lowest)] if written.codes else []
    return kind.reading(sensor, _EARLIER if late else None, codes + [0.0] * len(written.fields))


def _cut(field: str, record: Record, encoding: Encoding) -> tuple[bytes, bytes]:
    """Return the bytes that begin the list of a reading, and those of the reading itself."""
    data = encode(Sensors(**{field: (record,)}), encoding)  # type: ignore[arg-type]
    if encoding is Encoding.XML:
        return b"", data[len("<Sensors>") : -len("</Sensors>")]
    begin = data.index(b"[") + 1
    return data[1:begin], data[begin:-2]


def _steps(
    record: Record, item: bytes, written: Written, text: _Text, encoding: Encoding
) -> list[tuple[int, int, int, int]]:
    """Return the steps that write a reading."""
    wires = {member.name: member.wire for member in shape_of(type(record)).members}
    numbers = {"tick": (kernel.TICK, 0)}
    for at, (name, what) in enumerate(written.fields):
        numbers[name] = what, at + bool(written.codes)
    found = []
    for name, (what, at) in numbers.items():
        if getattr(record, name) is not None:
            # No id has a quotation mark or a space, so this stands nowhere but before the number.
            marker = (f' {wires[name]}="' if encoding is Encoding.XML else f'"{wires[name]}":').encode()
            begin = item.index(marker) + len(marker)
            found.append((begin, begin + len(_NUMBER.findall(item, begin)[0]), what, at))
    steps, place = [], 0
    for begin, end, what, at in sorted(found):
        steps.append((*text.add(item[place:begin]), what, at))
        place = end
    return [*steps, (*text.add(item[place:]), kernel.NOTHING, 0)]
