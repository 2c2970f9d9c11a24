"""A stand-in for a LUCI unit: its gRPC service and a chair that obeys it.

    python -m intellwheels_agents.bridge.luci_stand_in --listen 127.0.0.1:50051
    iw-bridge luci --address 127.0.0.1:50051 ...

It obeys overrides of the joystick from the input source that was added, and reports wheel angles, an inertial unit,
ultrasonic and radar points. Its motors stop 0.2 s after the last override. Faults are commanded on standard input or a
named pipe; `FAULTS` lists them. Standard output has `ready address=...`, and `source added=...`, `powered ms=...`,
`moving ms=...`, `stopped ms=... silence=...` as they happen, as of the firmware stand-in.
"""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from intellwheels_agents.bridge.command_pipe import CommandPipe
from intellwheels_agents.bridge.joystick_chair import JoystickChair
from intellwheels_agents.bridge.luci_options import listen_address
from intellwheels_agents.bridge.luci_readings import GRAVITY, STICK
from intellwheels_agents.bridge.luci_schema import IMU_MPU, SERVICE, message, parsed
from intellwheels_schemas.command_parser import CommandParser, number, readable_file
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.process import add_process_options, stop_on_signals

if TYPE_CHECKING:
    import grpc

PROGRAM: Final = "python -m intellwheels_agents.bridge.luci_stand_in"
STEP: Final = 0.01
STREAM_PERIOD: Final = 0.02
FAULTS: Final = """\
faults and other events, one a line:
  vanish S        the unit is gone for S seconds
  silence S       its streams send nothing for S seconds
  garbage S       its streams send malformed messages for S seconds
  huge S          its streams send messages of 300 kB for S seconds
  radians S       wheel angles are in radians for S seconds
  magnet S        the encoder of the left wheel has no magnet for S seconds
  centre N        from then on, the unit treats an override value of N as a centred joystick
  stick F T       the user deflects the joystick forward by F and to the left by T, in [-100, 100]
  wall M          the ultrasonic sensors see a point M metres ahead of the centre of movement; 0 for none
  edge            the encoder board restarts
"""


class LuciChair:
    """The unit without its network. The time is an argument; a lock keeps its threads apart.

    Attributes:
        chair: Its motors.
    """

    def __init__(self, wheel_diameter: float, top_speed: float) -> None:
        self.chair = JoystickChair(top_speed)
        self._turn = math.pi * wheel_diameter
        self._source: int | None = None
        self._centre = STICK
        self._user = (0, 0)
        self._wall = 0.0
        self._edge_from = 0.0
        self._until: dict[str, float] = {}
        self._lock = threading.Lock()

    def command(self, line: str) -> None:
        """Obey a line of standard input.

        Raises:
            ValueError: It is none of `FAULTS`.
        """
        word, *numbers = line.split() or [""]
        values = [float(text) for text in numbers]
        with self._lock:
            match word, values:
                case "vanish" | "silence" | "garbage" | "huge" | "radians" | "magnet", [seconds]:
                    self._until[word] = self.chair.clock + seconds
                case "centre", [centre]:
                    self._centre = int(centre)
                case "stick", [forward, left]:
                    self._user = int(forward), int(left)
                case "wall", [metres]:
                    self._wall = metres
                case "edge", []:
                    self._edge_from = self.chair.clock
                case _:
                    raise ValueError(line)

    def has(self, fault: str) -> bool:
        """Return whether a fault is in force."""
        return self._until.get(fault, 0.0) > self.chair.clock

    def step(self, seconds: float) -> list[str]:
        """Advance by some seconds; return the lines to print."""
        with self._lock:
            self.chair.step(seconds)
            return self.chair.take_messages()

    def add_source(self, source: int) -> None:
        """Let an input source steer."""
        with self._lock:
            self._source = source
            self.chair.messages.append(f"source added={source}")

    def remove_source(self, source: int) -> None:
        """Let the user's joystick steer again."""
        with self._lock:
            if source == self._source:
                self._source = None
                self.chair.command(0.0, 0.0)
                self.chair.messages.append(f"source removed={source}")

    def override(self, forward_back: int, left_right: int, source: int) -> None:
        """Obey an override, if it comes from the input source in force."""
        with self._lock:
            if source == self._source:
                forward, right = (max(-STICK, min(STICK, one - self._centre)) for one in (forward_back, left_right))
                self.chair.command(forward / STICK, -right / STICK)

    def report(self, method: str) -> bytes:
        """Return the next message of a stream."""
        with self._lock:
            if self.has("garbage"):
                return b"\x0d\x00\xff"
            if self.has("huge"):
                return b"\x0a" + b"\xff" * 300_000
            return bytes(self._message(method).SerializeToString())

    def _message(self, method: str) -> Any:
        match method:
            case "EncoderStream":
                unit = 2.0 * math.pi if self.has("radians") else 360.0
                left, right = (unit * (0.25 + travel / self._turn) % unit for travel in self.chair.travel)
                edge = round(1000.0 * (self.chair.clock - self._edge_from)) + 1
                left = 0.0 if self.has("magnet") else left
                return message("EncoderData", left_angle=left, right_angle=right, edge_timestamp=edge)
            case "ImuStream":
                return message("ImuData", gravity_z=GRAVITY, gyro_z=0.0, source=IMU_MPU)
            case "UltrasonicStream":
                arc = [message("Point3D", x=0.0, y=self._wall)] if self._wall > 0.0 else []
                return message("UltrasonicDistances", distances=[message("UltrasonicDistance", arc_points=arc)])
            case "RadarStream":
                return message("RadarPoints", source=3)
            case "UserJoystickStream":
                return message("JoystickData", forward_back=self._user[0], left_right=-self._user[1], source=4)
            case _:
                forward, turn = (round(STICK * one) for one in self.chair.stick)
                source = 4 if self._source is None else self._source
                joystick = message("JoystickData", forward_back=forward, left_right=-turn, source=source)
                return message("ActiveScaling", joystick=joystick)


STREAMS: Final = (
    "EncoderStream", "ImuStream", "UltrasonicStream", "RadarStream", "UserJoystickStream", "ActiveScalingStream",
)  # fmt: skip


def serve(luci: LuciChair, address: str, ended: threading.Event) -> tuple[grpc.Server, int]:
    """Start the service; return it and its port. Its streams end when `ended` is set."""
    import grpc  # noqa: PLC0415 - an optional dependency, which agents do not need

    def stream(method: str) -> Callable[[bytes, Any], Iterator[bytes]]:
        def messages(_request: bytes, context: Any) -> Iterator[bytes]:
            while not ended.wait(STREAM_PERIOD) and context.is_active():
                if not luci.has("silence"):
                    yield luci.report(method)

        return messages

    def unary(handle: Callable[[Any], None], kind: str) -> Callable[[bytes, Any], bytes]:
        def answer(request: bytes, _context: Any) -> bytes:
            handle(parsed(kind, request))
            return bytes(message("Response", reply="ok").SerializeToString())

        return answer

    server = grpc.server(ThreadPoolExecutor(max_workers=32), options=[("grpc.so_reuseport", 0)])
    handlers = {name: grpc.unary_stream_rpc_method_handler(stream(name)) for name in STREAMS}
    for name, kind, handle in (
        (
            "JsOverride",
            "RemoteJsValues",
            lambda asked: luci.override(asked.forward_back, asked.left_right, asked.source),
        ),
        ("AddInputSource", "InputSourceRequest", lambda asked: luci.add_source(asked.source)),
        ("RemoveInputSource", "InputSourceRequest", lambda asked: luci.remove_source(asked.source)),
    ):
        handlers[name] = grpc.unary_unary_rpc_method_handler(unary(handle, kind))
    service = grpc.method_handlers_generic_handler(SERVICE.strip("/"), handlers)
    server.add_generic_rpc_handlers((service,))
    port = server.add_insecure_port(address)
    server.start()
    return server, port


def parser() -> CommandParser:
    """Return the command line."""
    result = CommandParser(
        prog=PROGRAM,
        description="Play a LUCI unit and its chair, to which iw-bridge luci connects.",
        epilog=FAULTS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument(
        "--listen", type=listen_address, default="127.0.0.1:50051", metavar="HOST:PORT",
        help="address of the service; port 0 for a free one (default: 127.0.0.1:50051)",
    )  # fmt: skip
    result.add_argument(
        "--ask", type=readable_file, metavar="PIPE", help="named pipe to read faults from (default: standard input)"
    )
    result.add_argument(
        "--wheel", type=number("metres", 0.05, 2.0), default=0.368, metavar="M",
        help="wheel diameter, in [0.05, 2] (default: 0.368)",
    )  # fmt: skip
    result.add_argument(
        "--top-speed", type=number("m/s", 0.1, 5.0), default=1.0, metavar="V",
        help="speed at full deflection, in m/s, in [0.1, 5] (default: 1)",
    )  # fmt: skip
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the stand-in and return its exit code."""
    given = parser().parse_args(arguments)
    lacking = missing_extra("luci")
    if lacking is not None:
        _log(lacking)
        return 2
    stop = stop_on_signals(given.lifeline)
    return run(LuciChair(given.wheel, given.top_speed), given.listen, given.ask, stop)


def run(luci: LuciChair, address: str, ask: Path | None, stop: threading.Event) -> int:
    """Serve until `stop` is set; return the exit code."""
    commands = CommandPipe(ask, luci.command, lambda line: _log(f"expected a fault and its numbers, got {line!r}"))
    ended = threading.Event()
    try:
        server, port = serve(luci, address, ended)
    except RuntimeError as error:
        _log(f"--listen: expected HOST:PORT that is free, got {address}: {error}")
        return 1
    address = f"{address.rpartition(':')[0]}:{port}"
    _print(f"ready address={address}")
    last, is_there = time.monotonic(), True
    while not stop.is_set():
        commands.poll(STEP)
        now = time.monotonic()
        for line in luci.step(min(now - last, 2.0 * STEP)):
            _print(line)
        last = now
        if luci.has("vanish") and is_there:
            ended.set()
            server.stop(grace=0).wait(2.0)
            is_there = False
        elif not luci.has("vanish") and not is_there:
            ended = threading.Event()
            server, _ = serve(luci, address, ended)
            is_there = True
    ended.set()
    server.stop(grace=0).wait(2.0)
    return 0


def _log(line: str) -> None:
    print(f"{PROGRAM}: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


if __name__ == "__main__":
    sys.exit(main())
