"""Crews of bare chairs in one process, as light as they can be: they read the tick and answer at once, all together.

python -m tests.bench.crew_chairs ENDPOINT WORLD CHAIRS CREWS
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import traceback

import msgspec
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.crew_messages import crew_join, crew_messages
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import CrewJoined
from intellwheels_schemas.names import new_hex
from tests.bench.chairs import Head, chair


class CrewHead(msgspec.Struct, rename="pascal"):
    """All that a crew that drives ahead needs of its measures."""

    measures: list[Head]
    part: int = 0
    parts: int = 1


class CrewOfChairs:
    """The chairs of one session."""

    def __init__(self, session: zenoh.Session, keys: Keys, crew: str, numbers: range) -> None:
        self._arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
        self._read = msgspec.json.Decoder(CrewHead)
        self._held: list[object] = [session]  # else it is closed, and its chairs leave
        names, instance = [f"a{number:04d}" for number in numbers], new_hex()
        self._held.append(session.declare_subscriber(keys.crew_measures(crew), self._arrived.put))
        self._held += [link.declare_token(session, keys.token(name, "both", instance, crew)) for name in names]
        robots = [encode(chair(name, instance)) for name in names]
        data = crew_join(crew, instance, robots, Encoding.JSON)
        answer = link.query(session, keys.crew_join(crew), data, timeout=120.0)[0]
        if not answer.ok:
            raise SystemExit(answer.data.decode())
        joined = msgspec.json.decode(answer.data, type=CrewJoined)
        if joined.refused:
            raise SystemExit(joined.refused[0].text)
        self._publisher = link.declare(session, keys.crew_actions(crew), CHANNELS["crew_actions"])
        items = [
            f'{{"Run":"@RUN","Session":"{one.session}","Tick":@TICK,"LeftMotor":0.2,"RightMotor":0.21,'
            f'"Agent":"{one.agent}"}}'.encode()
            for one in joined.joined
        ]
        (self._answer,) = crew_messages("Actions", crew, items, Encoding.JSON)

    def serve(self) -> None:
        """Answer for ever."""
        take, read, answer, put = self._arrived.get, self._read.decode, self._answer, self._publisher.put
        while True:
            head = read(take().payload.to_bytes())
            if head.part + 1 == head.parts:
                run, tick = head.measures[0].run.encode(), str(head.measures[0].tick).encode()
                put(answer.replace(b"@RUN", run).replace(b"@TICK", tick))


def main() -> None:
    """Join, say so, and answer until standard input ends."""
    address, world, chairs, crews = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    keys = Keys(world)
    share = chairs // crews
    for number in range(crews):
        session = link.open_session(link.Link(connect=(address,)), threading.Event())
        assert session is not None
        crew = CrewOfChairs(session, keys, f"crew{number}", range(number * share, (number + 1) * share))
        threading.Thread(target=crew.serve, daemon=True).start()
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
