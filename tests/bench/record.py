"""What `iw-record` costs: a tick of a chair, as messages and as bytes of a file, in MCAP and in a bag of ROS 2."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import msgspec

from intellwheels_agents.record_gateway.bag_writer import BagWriter
from intellwheels_agents.record_gateway.message_sinks import MessageSinks
from intellwheels_agents.record_gateway.ros_translator import RosTranslator
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
    measured, keys = measures(state, "c"), Keys("bench")
    spent, spent_on_bag = 0.0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        path, bag_path = Path(folder) / "run.mcap", Path(folder) / "bag"
        sinks = MessageSinks(json_schemas(grows=True), path, 10**9)
        translator = Translator(keys, time.time)
        bag = BagWriter(bag_path, "mcap", RosTranslator(keys, translator))
        body = encode(Body(run=RUN, tick=0, robot=robot("intellwheels")))
        for entry in translator.take(keys.body("c"), body, JSON):
            sinks.write(entry)
        for tick in range(1, rounds + 1):
            seconds = 0.05 * tick
            shown = WorldState(run=RUN, tick=tick, time=seconds, entity=(Entity(name="c", x=1, y=2, heading=0),))
            of_tick = encode(msgspec.structs.replace(measured, tick=tick, time=seconds))
            for key, data in ((keys.state(0), encode(shown)), (keys.measures("c"), of_tick)):
                began = time.perf_counter()
                for entry in translator.take(key, data, JSON):
                    sinks.write(entry)
                between = time.perf_counter()
                bag.take(key, data, JSON)
                spent, spent_on_bag = spent + between - began, spent_on_bag + time.perf_counter() - between
            sinks.tend()
        sinks.close({})
        bag.close()
        size, bag_size = path.stat().st_size, sum(file.stat().st_size for file in bag_path.iterdir())
    return [
        Row("record", "intellwheels", "tick of a chair", 1e6 * spent / rounds, "µs"),
        Row("record", "intellwheels", "size of a tick", size / rounds, "bytes"),
        Row("record", "intellwheels", "tick of a chair in a bag", 1e6 * spent_on_bag / rounds, "µs"),
        Row("record", "intellwheels", "size of a tick in a bag", bag_size / rounds, "bytes"),
    ]
