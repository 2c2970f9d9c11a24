"""What `iw-ciber` costs: a tick of a robot, and the CPU of the process with four robots at 20 Hz."""

from __future__ import annotations

import socket
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path

from intellwheels_agents.ciber_gateway.ciber_robot import ciber_robot
from intellwheels_agents.ciber_gateway.client_messages import Registration, read_orders
from intellwheels_agents.ciber_gateway.lab_frame import lab_of
from intellwheels_agents.ciber_gateway.robot_state import RobotState
from intellwheels_agents.ciber_gateway.simulator_messages import Settings
from intellwheels_maps import floor
from intellwheels_schemas.file_records import Join
from intellwheels_server.world import Setup, apply, begin, measures
from tests.bench.network import WORLD, cpu_of, process, wait_for
from tests.bench.rows import Row
from tests.bench.sink import endpoint

LAB = '<Lab Name="Bench" Width="12" Height="8"><Beacon X="10" Y="6" Height="2"/><Target X="10" Y="6" Radius="1"/></Lab>'
STARTS = [(2, 2), (2, 4), (2, 6), (4, 2)]
ORDERS = b'<Actions LeftMotor="0.05" RightMotor="0.04"/>'


def lab_in(folder: Path) -> Path:
    """Write a lab with a grid, and return its file."""
    grid = "".join(f'<Position X="{x}" Y="{y}" Dir="0"/>' for x, y in STARTS)
    (folder / "BenchGrid.xml").write_text(f"<Grid>{grid}</Grid>")
    path = folder / "BenchLab.xml"
    path.write_text(LAB)
    return path


def cost_of_a_tick(path: Path, rounds: int) -> float:
    """Return the microseconds in which measures become a datagram, and the answer actions."""
    document = floor(str(path))
    lab = lab_of(document)
    robot = ciber_robot(Registration("robot"), lab, gps=True, beacons=True, beacon_height=2.0)
    run = "0123456789abcdef"
    state, _ = apply(begin(Setup(floor=document, seed="1"), run=run), [Join(agent="r", robot=robot)])
    measured, shown = measures(state, "r"), RobotState(1, "r", "r", Settings())
    shown.begin(robot, 0.05, run, lab)
    began = time.perf_counter()
    for _ in range(rounds):
        shown.sense(measured, {})
        shown.obey(read_orders(ORDERS))
        shown.actions()
    return 1e6 * (time.perf_counter() - began) / rounds


def cpu_share(path: Path, seconds: float) -> float:
    """Return the share of a core that a gateway with four robots uses in real time, their agents not counted."""
    address = endpoint()
    with ExitStack() as stack:
        simulator = stack.enter_context(
            process("intellwheels_server", "--map", str(path), "--world", WORLD, "--listen", address)
        )
        wait_for(simulator, "ready")
        gateway = stack.enter_context(
            process("intellwheels_agents.ciber_gateway", "--port", "0", "--world", WORLD, "--connect", address)
        )
        port = int(wait_for(gateway, "ready").split("port=")[1].split()[0])
        over = threading.Event()
        for number in range(len(STARTS)):
            client = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            client.settimeout(30.0)
            client.sendto(f'<Robot Id="{number + 1}" Name="b"/>'.encode(), ("127.0.0.1", port))
            agent = threading.Thread(target=_answer, args=(client, client.recvfrom(1024)[1], over))
            agent.start()
            stack.callback(agent.join)
        stack.callback(over.set)
        threading.Event().wait(1.0)  # the first ticks are not the rule
        cpu, began = cpu_of(gateway.pid), time.monotonic()
        threading.Event().wait(seconds)
        return (cpu_of(gateway.pid) - cpu) / (time.monotonic() - began)


def _answer(client: socket.socket, address: tuple[str, int], over: threading.Event) -> None:
    while not over.is_set():
        client.recv(4096)
        client.sendto(ORDERS, address)


def bench(*, rounds: int = 2000, seconds: float = 20.0) -> list[Row]:
    """Return the rows. Without seconds there is none of the process."""
    with tempfile.TemporaryDirectory() as folder:
        path = lab_in(Path(folder))
        rows = [Row("ciber", "1 robot", "tick of a robot", cost_of_a_tick(path, rounds), "µs")]
        if seconds > 0.0:
            share = 100.0 * cpu_share(path, seconds)
            rows.append(Row("ciber", f"{len(STARTS)} robots, 20 Hz", "CPU of iw-ciber", share, "% of a core"))
    return rows
