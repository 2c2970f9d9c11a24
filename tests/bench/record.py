"""What `iw-record` costs: a tick of a chair, as messages and as bytes of a file."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from intellwheels_agents.record_gateway.message_sinks import MessageSinks
from intellwheels_agents.record_gateway.translator import Translator
from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import encode
from intellwheels_schemas.file_records import Join
from intellwheels_schemas.json_schema import json_schemas
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body, Entity, WorldState
from intellwheels_server.world import Setup, apply, begin, measures
from tests.bench.rows import Row

RUN = "0123456789abcdef"
JSON = "application/json"


def bench(*, rounds: int = 2000) -> list[Row]:
    """Return the rows."""
    state = begin(Setup(floor=floor("room"), seed="1"), run=RUN)
    state, _ = apply(state, [Join(agent="c", robot=robot("intellwheels"))])
    measured, keys = encode(measures(state, "c")), Keys("bench")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        sinks = MessageSinks(json_schemas(grows=True), path, 10**9)
        translator = Translator(keys, time.time)
        body = encode(Body(run=RUN, tick=0, robot=robot("intellwheels")))
        for entry in translator.take(keys.body("c"), body, JSON):
            sinks.write(entry)
        began = time.perf_counter()
        for tick in range(1, rounds + 1):
            shown = WorldState(run=RUN, tick=tick, time=0.05 * tick, entity=(Entity(name="c", x=1, y=2, heading=0),))
            for key, data in ((keys.state(0), encode(shown)), (keys.measures("c"), measured)):
                for entry in translator.take(key, data, JSON):
                    sinks.write(entry)
            sinks.tend()
        spent = time.perf_counter() - began
        sinks.close({})
        size = path.stat().st_size
    return [
        Row("record", "intellwheels", "tick of a chair", 1e6 * spent / rounds, "µs"),
        Row("record", "intellwheels", "size of a tick", size / rounds, "bytes"),
    ]
