"""Bytes of strangers on every inbound key: the simulator complains or is silent, keeps running and does not grow."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.e2e.stage import JSON, XML, Peer, Stage, resident

VECTORS = Path(__file__).parent.parent.parent / "schemas" / "vectors"
ENCODINGS = (JSON, XML, "text/plain", "", "zenoh/bytes", "application/json;iw.v9", "image/png")
ALLOWED = 105
"""Bytes of growth for each message after the first rounds."""
THIRD = 8
"""Rounds of messages in a third of a test of memory."""

# Each with a body that is really read; vectors of the class are mixed in.
PUT_KEYS = {
    "in/{agent}/actions": "Actions", "in/{agent}/say": "Say", "in/{agent}/pose": "Pose", "user/{agent}": "UserInput",
    "crew/{agent}/actions": "CrewActions", "in/{agent}/nothing": "Actions", "in/{agent}/actions/more": "Actions",
}  # fmt: skip
VERBS = ("pause", "resume", "step", "reset", "load", "speed", "spawn", "delete", "teleport", "take", "say", "save",
         "restore", "seek", "nothing")  # fmt: skip
SEEDS = (
    b"",
    b'{"Session":"00000000000000ff","LeftMotor":0.5,"RightMotor":0.4,"Tick":5,"Seq":1}',
    b'<Actions Session="00000000000000ff" LeftMotor="0.5"><Say><![CDATA[x]]></Say></Actions>',
    b'{"X":1.0,"Y":2.0,"Heading":0.0}', b'{"Forward":1.0,"Turn":-1.0,"Buttons":[1,2]}',
    b'{"Text":"words"}', b"words",
    b'{"Kind":"wheelchair","Part":[{"X":0,"Y":0,"Length":1,"Width":1,"Bottom":0,"Top":1}]}',
    b'<!DOCTYPE a [<!ENTITY b "c">]><Actions>&b;</Actions>',
    b"[" * 3000, b'{"a":' * 500, b"<a>" * 1000, b"\x00", b"\xff\xfe",
    b'{"LeftMotor":NaN}', b'{"LeftMotor":1e999}', b'{"Tick":99999999999999999999}', b'{"LeftMotor":1,"LeftMotor":2}',
)  # fmt: skip


def seeds() -> list[bytes]:
    vectors = [path.read_bytes() for path in sorted(VECTORS.rglob("*")) if path.suffix in (".json", ".xml")]
    return [*SEEDS, *(data for data in vectors if len(data) < 3000)]


def mutated(data: bytes, chance: random.Random) -> bytes:
    """Return bytes near to some that are right."""
    out = bytearray(data)
    for _ in range(chance.choice((0, 1, 1, 2, 8))):
        at = chance.randrange(len(out) + 1)
        match chance.randrange(4):
            case 0:
                out[at:at] = chance.randbytes(chance.randrange(1, 5))
            case 1:
                del out[at : at + chance.randrange(1, 9)]
            case 2 if at < len(out):
                out[at] ^= 1 << chance.randrange(8)
            case _:
                out[at:at] = out[max(0, at - 20) : at]
    return bytes(out)


def flood(peer: Peer, count: int, chance: random.Random) -> None:
    """Put so many messages, by the joined agent, by others and by ever new names."""
    documents = seeds()
    keys = list(PUT_KEYS)
    for number in range(count):
        agent = chance.choice(("chair1", "stranger", f"n{number}"))
        key = chance.choice(keys).format(agent=agent)
        peer.put(key, mutated(chance.choice(documents), chance), chance.choice(ENCODINGS))
        if number % 500 == 499:
            # An answer comes behind what was put before: what waits to be read would hide what is kept.
            peer.ask("clock")


def questions(count: int, chance: random.Random) -> Iterator[tuple[str, bytes, str]]:
    documents = seeds()
    for number in range(count):
        key = chance.choice(
            (f"join/n{number}", "join/chair1", "leave/chair1", "leave/stranger", f"ctl/{chance.choice(VERBS)}",
             f"event?since={chance.choice(('x', '-1', '1e9', '99999999999999999999', ''))}", "map", "state/7",
             "join/x y")
        )  # fmt: skip
        yield key, mutated(chance.choice(documents), chance), chance.choice(ENCODINGS)


def test_raw_bytes_on_every_inbound_key_end_in_words_or_silence(stage: Stage) -> None:
    server = stage.server("--map", "room", "--pace", "realtime")
    agent = stage.agent("chair1", "drive")
    chance = random.Random(1)
    with stage.peer() as peer:
        for key, data, encoding in questions(600, chance):
            if key == "leave/chair1" and b"Session" not in data:
                continue
            for _ in peer.session.get(peer.prefix + key, payload=data, encoding=encoding, timeout=5.0):
                pass
        for key in ("ctl/resume", "ctl/quit"):
            for data in (b"\xff", b'{"Nope":1}', b"<Nope/>"):
                assert [reply["Code"] for reply in peer.ask(key, data)] == ["failed"]
        peer.ctl("speed", Factor=1.0)
        peer.ctl("resume")
        peer.ticks_on(5)
    assert "Traceback" not in stage.log(server)
    assert "Traceback" not in stage.log(agent)


@pytest.mark.parametrize("messages", [4_000, pytest.param(10_000, marks=pytest.mark.soak)])
def test_memory_does_not_grow_with_messages_of_strangers(stage: Stage, messages: int) -> None:
    server = stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "drive")
    chance = random.Random(2)
    sizes = []
    with stage.peer() as peer:
        for _ in range(3 * THIRD):
            flood(peer, messages, chance)
            peer.ticks_on(5)
            sizes.append(resident(stage.pid(server)))
    assert "Traceback" not in stage.log(server)
    # The first third warms caches and the allocator up. What grows with messages still grows after it, whereas the
    # allocator goes up and down in steps of megabytes. So the peaks of the two later thirds are compared.
    grown = (max(sizes[2 * THIRD :]) - max(sizes[THIRD : 2 * THIRD])) / THIRD / messages
    assert grown < ALLOWED, [size / 2**20 for size in sizes]


def test_complaints_say_where_and_what(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "table", robot="table")
    with stage.peer() as peer:
        errors = peer.errors("chair1")
        wrong = {
            "malformed": (b"{", JSON),
            "value": (b'{"Session":"00000000000000ff","LeftMotor":"fast"}', JSON),
            "field": (b'{"Session":"00000000000000ff","LeftMoter":0.5}', JSON),
            "encoding": (b"\x00\x01", "zenoh/bytes"),
            "version": (b"{}", "application/json;iw.v9"),
            "too-long": (json.dumps({"Session": "00000000000000ff", "Say": "a" * 5000}).encode(), JSON),
            "session": (b'{"Session":"00000000000000ff"}', JSON),
        }
        for code, (data, encoding) in wrong.items():
            peer.put("in/chair1/actions", data, encoding)
            error = peer.error(errors, code)
            assert error["Text"]
        value = peer.error(errors, "value")
        assert (value["Where"], value["Text"]) == (
            "Actions.LeftMotor",
            "Actions.LeftMotor: expected a number in [-1, 1], got 'fast'",
        )
