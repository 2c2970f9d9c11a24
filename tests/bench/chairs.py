"""Many bare chairs in one process, as light as an agent can be: they read the tick and answer at once.

python -m tests.bench.chairs ENDPOINT WORLD CHAIRS SESSIONS [FOLDER] [--xml]

With FOLDER, each session has the identity of a student whose file is there, and the names of its chairs begin as his.
An empty FOLDER gives the names alone. With --xml, the chairs speak XML.

The first chair of each session stands and starts to turn now and then. When standard input ends, a line says how many
milliseconds it took each time from the command to the first measures that show the turn.
"""

from __future__ import annotations

import argparse
import os
import queue
import re
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Final

import msgspec
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Joined, Odometry, Robot
from intellwheels_schemas.names import new_hex
from tests.bench.tick import SENSORS


def chair(name: str, instance: str) -> Robot:
    """Return the robot of a chair with eight cones."""
    return Robot(
        name=name,
        kind="wheelchair",
        instance=instance,
        length=1.2,
        width=0.7,
        center=0.4,
        top=1.3,
        top_speed=1.0,
        track=0.57,
        acceleration_curve=0.5,
        proximity=SENSORS,
    )


STILL: Final = 40
"""Measures for which a probe stands before it turns: until no rest of the last turn moves it."""
TURN: Final = 5
"""Measures for which a probe turns on."""
LOST: Final = 40
"""Measures after which a turn that shows nothing is given up: a wall blocks it."""


class Head(msgspec.Struct, rename="pascal"):
    """All that a chair that drives ahead needs of its measures."""

    run: str
    tick: int


class Probe:
    """A chair that stands, turns now and then, and notes how long the measures take to show it.

    Attributes:
        delays: Time from each command to the measures that show its effect, s.
    """

    def __init__(self) -> None:
        self.delays: list[float] = []
        self._state = "still"
        self._count = 0
        self._put = 0.0
        self._shown: bytes | None = None

    def powers(self, payload: bytes) -> tuple[float, float]:
        """Return the powers of the motors after these measures."""
        now, found = time.perf_counter(), _HEADING.search(payload)
        heading = found.group(1) if found else None
        changed, self._shown = heading != self._shown, heading
        self._count += 1
        if self._state == "still" and changed:
            self._count = 0
        elif self._state == "still" and self._count >= STILL:
            self._state, self._count, self._put = "asked", 0, now
        elif self._state == "asked" and changed:
            self.delays.append(now - self._put)
            self._state, self._count = "turning", 0
        elif (self._state == "asked" and self._count >= LOST) or (self._state == "turning" and self._count >= TURN):
            self._state, self._count = "still", 0
        return (0.0, 0.0) if self._state == "still" else (0.3, -0.3)


_HEADING: Final = re.compile(rb'Heading"?[:=]"?([-+.0-9e]+)')
_XML_HEAD: Final = re.compile(rb'<Measures Run="([0-9a-f]+)" Tick="([0-9]+)"')


def _xml_head(payload: bytes) -> Head:
    found = _XML_HEAD.match(payload)
    assert found is not None, payload
    return Head(found.group(1).decode(), int(found.group(2)))


class Chairs:
    """The chairs of one session, by their names."""

    def __init__(self, session: zenoh.Session, keys: Keys, names: list[str], encoding: Encoding) -> None:
        self.probe = Probe()
        self._arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
        self._xml = encoding is Encoding.XML
        self._read = _xml_head if self._xml else msgspec.json.Decoder(Head).decode
        self._answers: dict[str, tuple[zenoh.Publisher, str]] = {}
        self._probed = keys.measures(names[0])
        self._held: list[object] = [session]  # else it is closed, and its chairs leave
        for name in names:
            key = keys.measures(name)
            self._held.append(session.declare_subscriber(key, self._arrived.put))
            instance = new_hex()
            self._held.append(link.declare_token(session, keys.token(name, "both", instance)))
            robot = chair(name, instance)
            if key == self._probed:
                robot = msgspec.structs.replace(robot, odometry=(Odometry(id="o"),))
            answer = link.query(session, keys.join(name), encode(robot, encoding), encoding, timeout=20.0)[0]
            if not answer.ok:
                raise SystemExit(answer.data.decode())
            joined = decode(Joined, answer.data, encoding, strict=False)
            publisher = link.declare(session, keys.actions(name), CHANNELS["actions"], encoding)
            self._answers[key] = (publisher, f"{joined.session}")

    def serve(self) -> None:
        """Answer for ever."""
        take, read, answers, probed = self._arrived.get, self._read, self._answers, self._probed
        form = XML if self._xml else JSON
        while True:
            sample = take()
            payload, key = sample.payload.to_bytes(), str(sample.key_expr)
            head = read(payload)
            left, right = self.probe.powers(payload) if key == probed else (0.2, 0.21)
            publisher, own = answers[key]
            publisher.put((form % (head.run, own, head.tick, left, right)).encode())


JSON: Final = '{"Run":"%s","Session":"%s","Tick":%d,"LeftMotor":%s,"RightMotor":%s}'
XML: Final = '<Actions Run="%s" Session="%s" Tick="%d" LeftMotor="%s" RightMotor="%s"/>'


def main() -> None:
    """Join, say so, answer until standard input ends, and print the delays."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.chairs", description=__doc__)
    parser.add_argument("endpoint")
    parser.add_argument("world")
    parser.add_argument("chairs", type=int)
    parser.add_argument("sessions", type=int)
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--xml", action="store_true")
    options = parser.parse_args()
    keys, folder = Keys(options.world), options.folder
    encoding = Encoding.XML if options.xml else Encoding.JSON
    share = options.chairs // options.sessions
    probes = []
    for number in range(options.sessions):
        identity = Path(folder) / f"student{number}.iwid" if folder else None
        session = link.open_session(link.Link(connect=(options.endpoint,), identity=identity), threading.Event())
        assert session is not None
        names = [f"a{k:04d}" if folder is None else f"st{number}-{k - number * share}"
                 for k in range(number * share, (number + 1) * share)]  # fmt: skip
        some = Chairs(session, keys, names, encoding)
        probes.append(some.probe)
        threading.Thread(target=some.serve, daemon=True).start()
    print("ready", flush=True)
    sys.stdin.read()
    print("delays", *(f"{1e3 * delay:.1f}" for probe in probes for delay in probe.delays), flush=True)


if __name__ == "__main__":
    try:
        main()
    finally:
        # Sessions with callbacks hang at exit; nothing here is worth a clean end.
        traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)
