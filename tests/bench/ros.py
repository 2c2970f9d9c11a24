"""What `iw-ros` costs: the messages of a chair at a tick, and the CPU of the process at 20 Hz."""

from __future__ import annotations

import threading
import time
from contextlib import ExitStack

from intellwheels_agents.ros_gateway.chair_messages import ChairMessages
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_types import encode_message
from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Join
from intellwheels_server.world import Setup, apply, begin, measures
from tests.bench.network import WORLD, cpu_of, process, wait_for
from tests.bench.rows import Row
from tests.bench.sink import endpoint

ROBOTS = ("lidar-chair", "intellwheels")


def cost_of_a_tick(name: str, rounds: int) -> tuple[float, float]:
    """Return the microseconds in which the messages of a tick are made, and those in which they become bytes."""
    state = begin(Setup(floor=floor("room"), seed="1"), run="0123456789abcdef")
    state, _ = apply(state, [Join(agent="c", robot=robot(name))])
    measured = measures(state, "c")
    made, encoded = 0.0, 0.0
    for _ in range(rounds):
        messages = ChairMessages("c", robot(name), 0.05, PlanePose(0.0, 0.0, 0.0))
        began = time.perf_counter()
        found = list(messages.messages(measured))
        between = time.perf_counter()
        for message in found:
            encode_message(message.message)
        made, encoded = made + between - began, encoded + time.perf_counter() - between
    return 1e6 * made / rounds, 1e6 * encoded / rounds


def cpu_share(name: str, seconds: float) -> float:
    """Return the share of a core that a gateway with one chair uses in real time."""
    address = endpoint()
    with ExitStack() as stack:
        simulator = stack.enter_context(
            process("intellwheels_server", "--map", "ward", "--world", WORLD, "--listen", address)
        )
        wait_for(simulator, "ready")
        gateway = stack.enter_context(process(
            "intellwheels_agents.ros_gateway", "--name", "c", "--robot", name, "--world", WORLD, "--connect", address
        ))  # fmt: skip
        wait_for(gateway, "joined")
        threading.Event().wait(1.0)  # the first ticks are not the rule
        cpu, began = cpu_of(gateway.pid), time.monotonic()
        threading.Event().wait(seconds)
        return (cpu_of(gateway.pid) - cpu) / (time.monotonic() - began)


def bench(*, rounds: int = 2000, seconds: float = 20.0) -> list[Row]:
    """Return the rows."""
    rows = []
    for name in ROBOTS:
        made, encoded = cost_of_a_tick(name, rounds)
        rows.append(Row("ros", name, "messages of a tick", made, "µs"))
        rows.append(Row("ros", name, "their CDR", encoded, "µs"))
    name = ROBOTS[0]
    rows.append(Row("ros", f"{name}, 20 Hz", "CPU of iw-ros", 100.0 * cpu_share(name, seconds), "% of a core"))
    return rows
