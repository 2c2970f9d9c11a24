"""What a tick costs the simulator, body by body: receive, decode, step, sense, encode, put.

A hospital floor of 140 x 60 m, made by the generator with a fixed seed; bodies of 1.2 x 0.7 m with 8 cones of 30
degrees and 4 m, driving about at random.
"""

from __future__ import annotations

import random
import subprocess
import sys
import threading
import time
from collections.abc import Callable

from msgspec.structs import replace

from intellwheels_maps.hospital import LENGTH, hospital
from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import VERSION, Encoding, decode, encode
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Actions, Grid, Map, Place, Proximity, Robot, Wall
from intellwheels_server.world import Setup, State, advance, apply, begin
from intellwheels_server.world.measures_writer import MeasuresWriter
from intellwheels_server.world.sensors import sense
from intellwheels_server.world.sensors.kind import View
from intellwheels_server.world.sensors.proximity import FEWEST_SHARED
from tests.bench.rows import Row
from tests.bench.sink import endpoint

SENSORS = tuple(
    Proximity(id=f"s{k}", x=0.6, y=0.0, z=0.4, direction_deg=45.0 * k, cone_deg=30.0, max_range=4.0) for k in range(8)
)
GOALS = {1: "<= 8", 10: "<= 2", 100: "<= 1.5", 1000: "<= 2", 10000: "<= 2.5"}
BODIES_OF_A_PLAN = 1000
APART = 10.0
"""Distance between two hospitals, m."""


def hospitals(plans: int) -> Map:
    """Return a map with so many hospitals side by side, each with a seed of its own; the first is `hospital(1)`."""
    walls: list[Wall] = []
    places: list[Place] = []
    for k in range(plans):
        one = hospital(1 + k)
        assert one.grid is not None
        east = k * (LENGTH + APART)
        for wall in one.wall:
            corners = tuple(replace(corner, x=corner.x + east) for corner in wall.corner)
            walls.append(replace(wall, corner=corners))
        places += [replace(spot, name=f"h{k}-{spot.name}", x=spot.x + east) for spot in one.grid.position]
    return Map(format=VERSION, name="hospitals", wall=tuple(walls), grid=Grid(position=tuple(places)))


def hospital_world(bodies: int, plans: int = 1) -> State:
    """Return a world with so many bodies at places of the hospital, or of several side by side."""
    floor = hospital(1) if plans == 1 else hospitals(plans)
    assert floor.grid is not None
    spots = list(floor.grid.position)
    random.Random(1).shuffle(spots)
    joins = [
        Join(
            agent=f"a{k:04d}",
            robot=Robot(
                kind="wheelchair",
                length=1.2,
                width=0.7,
                center=0.4,
                top=1.3,
                top_speed=1.0,
                track=0.57,
                acceleration_curve=0.5,
                place=spots[k].name,
                proximity=SENSORS,
            ),
        )
        for k in range(bodies)
    ]
    state, outputs = apply(begin(Setup(floor=floor), "0" * 16), joins)
    assert all(outcome.code == "ok" for outcome in outputs.outcomes)
    return state


def commands(state: State, seed: int = 1) -> list[dict[str, Actions]]:
    """Return 20 ticks of powers for everybody, to be repeated."""
    draw = random.Random(seed)
    return [
        {
            name: Actions(
                run=state.run,
                session="0" * 16,
                tick=0,
                seq=0,
                left_motor=draw.uniform(-0.2, 1.0),
                right_motor=draw.uniform(-0.2, 1.0),
            )
            for name in state.names
        }
        for _ in range(20)
    ]


def best(work: Callable[[], object], times: int, rounds: int = 5) -> float:
    """Return the seconds of one call in the quickest round: what is slower is the machine's noise."""
    found = []
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(times):
            work()
        found.append((time.perf_counter() - start) / times)
    return min(found)


def bench(sizes: tuple[int, ...] = (1, 10, 100, 1000, 10000), *, quick: bool = False) -> list[Row]:
    """Return the rows, µs a body and tick."""
    rows = []
    for count in sizes:
        times = max(2, (200 if quick else 4000) // count)
        rows.extend(_of(count, times))
    return rows


def _of(count: int, times: int) -> list[Row]:
    plans = -(-count // BODIES_OF_A_PLAN)
    state = hospital_world(count, plans)
    powers = commands(state)
    for k in range(20):
        state, _ = advance(state, Inputs(actions=powers[k]))
    held = [state]

    def move() -> None:
        held[0], _ = advance(held[0], Inputs(actions=powers[held[0].tick % 20]))

    whole = best(move, times)

    def move_by_two() -> None:
        held[0], _ = advance(held[0], Inputs(actions=powers[held[0].tick % 20]), threads=2)

    shared = best(move_by_two, times) if count >= FEWEST_SHARED else None
    state = held[0]
    view = View(
        state.numbers, state.body_set.bodies.parts, state.body_set.bodies.part_start, state.walls, state.setup.period
    )
    sensing = best(lambda: sense(state.body_set.plan, view, state.tick, state.samples), times)
    case = f"{count} bodies" if plans == 1 else f"{count} bodies in {plans} hospitals"
    share = 1e6 / count
    moving = [
        Row("tick", case, "step", (whole - sensing) * share, "µs/body"),
        Row("tick", case, "sense", sensing * share, "µs/body"),
        Row("tick", case, "step and sense", whole * share, "µs/body", GOALS.get(count, "")),
    ]
    if shared is not None:
        moving.append(Row("tick", case, "step and sense, 2 threads", shared * share, "µs/body"))
    if plans > 1:  # more agents than a simulator lets in
        return moving
    packed = [encode(action) for action in powers[0].values()]
    decoding = best(lambda: [decode(Actions, data) for data in packed], times)
    json_writer, xml_writer, names = MeasuresWriter(Encoding.JSON), MeasuresWriter(Encoding.XML), state.names
    encoding = best(lambda: json_writer.write(state, names), max(2, times // 5))
    xml = best(lambda: xml_writer.write(state, names), max(2, times // 5))
    putting, receiving = _network(state, packed, max(2, times // 5))
    return [
        Row("tick", case, "receive", receiving * share, "µs/body"),
        Row("tick", case, "decode", decoding * share, "µs/body", "<= 1"),
        *moving,
        Row("tick", case, "encode JSON", encoding * share, "µs/body", "<= 2"),
        Row("tick", case, "encode XML", xml * share, "µs/body", "<= 5"),
        Row("tick", case, "put", putting * share, "µs/body"),
    ]


def _network(state: State, packed: list[bytes], times: int) -> tuple[float, float]:
    """Return the seconds in which this process puts to everybody, and in which it takes what everybody sent.

    Receiving is this process's CPU time, callbacks and inbox together, while another process sends.
    """
    keys = Keys("bench")
    stop = threading.Event()
    address = endpoint()
    inbox = zenoh_inbox.Inbox(room=1 << 20)
    session = link.open_session(link.Link(listen=(address,)), stop)
    assert session is not None
    with session, session.declare_subscriber(keys.every_in, inbox.on_sample):
        child = subprocess.Popen(
            [sys.executable, "-m", "tests.bench.sink", address, str(len(packed)), str(times)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            assert child.stdout.readline() == "ready\n"
            publishers = [
                link.declare(session, keys.measures(f"a{k:04d}"), CHANNELS["measures"]) for k in range(len(packed))
            ]
            payloads = MeasuresWriter(Encoding.JSON).write(state, state.names)

            def put() -> None:
                for publisher, payload in zip(publishers, payloads, strict=True):
                    publisher.put(payload)

            put()
            putting = best(put, times, rounds=3)
            child.stdin.write("send\n")
            child.stdin.flush()
            start = time.process_time()
            assert child.stdout.readline() == "sent\n"
            taken = 0
            deadline = time.monotonic() + 20.0
            while taken < times * len(packed) and time.monotonic() < deadline:
                inbox.wait(0.2)
                found = len(inbox.take())
                taken += found
                if not found:
                    break
            receiving = (time.process_time() - start) / max(1, taken) * len(packed)
        finally:
            child.stdin.close()
            child.wait(20.0)
            child.stdout.close()
    return putting, receiving
