"""Many bare chairs in one process, as light as an agent can be: they read the tick and answer at once.

python -m tests.bench.chairs ENDPOINT WORLD CHAIRS SESSIONS [FOLDER]

With FOLDER, each session has the identity of a student whose file is there, and the names of its chairs begin as his.
An empty FOLDER gives the names alone.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import traceback
from pathlib import Path

import msgspec
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Joined, Robot
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


class Head(msgspec.Struct, rename="pascal"):
    """All that a chair that drives ahead needs of its measures."""

    run: str
    tick: int


class Chairs:
    """The chairs of one session, by their names."""

    def __init__(self, session: zenoh.Session, keys: Keys, names: list[str]) -> None:
        self._arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
        self._read = msgspec.json.Decoder(Head)
        self._answers: dict[str, tuple[zenoh.Publisher, str]] = {}
        self._held: list[object] = [session]  # else it is closed, and its chairs leave
        for name in names:
            key = keys.measures(name)
            self._held.append(session.declare_subscriber(key, self._arrived.put))
            instance = new_hex()
            self._held.append(link.declare_token(session, keys.token(name, "both", instance)))
            robot = chair(name, instance)
            answer = link.query(session, keys.join(name), encode(robot), timeout=20.0)[0]
            if not answer.ok:
                raise SystemExit(answer.data.decode())
            joined = msgspec.json.decode(answer.data, type=Joined)
            publisher = link.declare(session, keys.actions(name), CHANNELS["actions"])
            self._answers[key] = (publisher, f'"Session":"{joined.session}","LeftMotor":0.2,"RightMotor":0.21')

    def serve(self) -> None:
        """Answer for ever."""
        take, read, answers = self._arrived.get, self._read.decode, self._answers
        while True:
            sample = take()
            head = read(sample.payload.to_bytes())
            publisher, rest = answers[str(sample.key_expr)]
            publisher.put(f'{{"Run":"{head.run}","Tick":{head.tick},{rest}}}'.encode())


def main() -> None:
    """Join, say so, and answer until standard input ends."""
    address, world, chairs, sessions = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    keys = Keys(world)
    folder = sys.argv[5] if len(sys.argv) > 5 else None
    share = chairs // sessions
    for number in range(sessions):
        identity = Path(folder) / f"student{number}.iwid" if folder else None
        session = link.open_session(link.Link(connect=(address,), identity=identity), threading.Event())
        assert session is not None
        names = [f"a{k:04d}" if folder is None else f"st{number}-{k - number * share}"
                 for k in range(number * share, (number + 1) * share)]  # fmt: skip
        some = Chairs(session, keys, names)
        threading.Thread(target=some.serve, daemon=True).start()
    print("ready", flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    try:
        main()
    finally:
        # Sessions with callbacks hang at exit; nothing here is worth a clean end.
        traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)
