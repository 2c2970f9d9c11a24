"""How soon a real chair obeys again after an attack, and after its router was gone: within one tick. In simulated time.

The simulator's service, the harness of the mind, the harness of the bridge with its motor writer, and the controller of
the firmware stand-in run in one process. The test moves their clock, and carries their messages: those of strangers
too, as in an open world, or none, as behind a router that is gone. The mind commands another power at each tick, so the
power at the motors tells to which tick they obey. Whether a network and a busy machine carry messages in time is no
matter here; `test_attacks`, `test_lab_attacks` and `test_bridge` run the same with real processes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, NamedTuple

import msgspec
import pytest

from intellwheels_agents.bridge.firmware_stand_in import STEP, Controller
from intellwheels_agents.bridge.line_protocol import PowerLine, encode_line
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.motor_writer import MotorWriter
from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.bridge.real_chair import RealChair
from intellwheels_agents.bridge.sensor_merge import SensorMerge
from intellwheels_agents.harness import Harness
from intellwheels_agents.harness_outputs import AskBody, AskClock, Output, Payload, Publish, RequestJoin
from intellwheels_agents.mind import Context, Make
from intellwheels_agents.robot_document import joining
from intellwheels_maps import robot
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import Actions, Error, Measures, Pose, PowerInForce, Record, Role
from tests.agents.bridge.readings import FakeDriver, reading
from tests.server.stage import Stage

PERIOD: Final = 0.05
STEPS: Final = round(PERIOD / STEP)
NAME = "real1"
CHAIR = msgspec.structs.replace(robot("intellwheels"), type="real")
STRANGER, LAST = "f" * 16, 2**53 - 1
JSON = Encoding.JSON


def power_of(tick: int) -> float:
    """Return what the mind commands in its answer to the measures of a tick."""
    return (1 + tick % 900) / 1000.0


class Mind:
    """A mind whose command tells to which tick it belongs."""

    def __init__(self, _context: Context) -> None: ...

    def decide(self, measures: Measures) -> Actions:
        return Actions(left_motor=power_of(measures.tick), right_motor=-power_of(measures.tick))


class Line(FakeDriver):
    """The electronics: powers go to the controller as lines."""

    data = b""

    def write(self, left: float, right: float) -> None:
        self.data += encode_line(PowerLine(round(1000.0 * left), round(1000.0 * right)))


class Process(NamedTuple):
    """A mind or a bridge."""

    harness: Harness
    role: Role
    instance: str


class Room:
    """A simulator, a mind and a bridge in one process, and the messages between them.

    Attributes:
        is_linked: Whether messages are delivered.
        strangers: What strangers put at each tick, before and after the simulator's own measures.
        seen: The powers at the motors, one after the other, in thousandths.
        poses: The ticks whose measures the bridge has answered.
    """

    def __init__(self) -> None:
        self.stage = Stage(pace="realtime", strict=False)
        self.is_linked = True
        self.strangers: Callable[[Room, int], Sequence[Record]] = lambda _room, _tick: ()
        self.seen = [0]
        self.poses: list[int] = []
        self.powers: list[PowerInForce] = []
        self._answers: list[Callable[[], None]] = []
        self._controller, self._line = Controller(1, 0, 500.0), Line()
        motors = MotorDeadman()
        merge = SensorMerge(CHAIR, CHAIR, "both")
        chair = RealChair(
            self._line, PoseSource(CHAIR, "raw"), motors, merge, clock=lambda: self.stage.now, wall=lambda: 1e9
        )
        self._writer = MotorWriter(motors, self._line, lambda: chair.lockstep)
        self._heard = 0
        makes: dict[Role, Make] = {"body": chair.begin, "mind": Mind}
        self._processes = [
            Process(Harness(joining(CHAIR, agent=NAME, role=role, instance=instance, place=None, barrier=None), make),
                    role, instance)
            for (role, make), instance in zip(makes.items(), ("b" * 16, "a" * 16), strict=True)
        ]  # fmt: skip
        for process in self._processes:
            self.stage.token(NAME, process.role, process.instance)
            self._do(process, process.harness.start(self.stage.now))
        while self.stage.tick == 0:
            self._step()

    # ------------------------------------------------------------ the network

    def cut(self, *, noticed: bool) -> None:
        """Let the router go; a connection that is shut is noticed, one that only falls silent is not."""
        self.is_linked = False
        self._answers.clear()
        for process in self._processes if noticed else ():
            self.stage.token(NAME, process.role, process.instance, present=False)
            process.harness.absent(self.stage.now)

    def link(self, *, noticed: bool) -> None:
        """Let the router come back."""
        self.is_linked = True
        for process in self._processes if noticed else ():
            self.stage.token(NAME, process.role, process.instance)
            self._do(process, process.harness.present(self.stage.now))

    def _do(self, process: Process, outputs: Sequence[Output]) -> None:
        for output in outputs if self.is_linked else ():
            if isinstance(output, Publish) and process.role == "body":
                self.poses.append(decode(Pose, output.payload, strict=False).tick or 0)
                self.stage.put(NAME, output.payload, "pose")
            elif isinstance(output, Publish):
                self.stage.put(NAME, output.payload)
            elif isinstance(output, RequestJoin):
                self._answers.append(partial(self._join, process, output.payload))
            elif isinstance(output, AskClock):
                self._answers.append(partial(self._tell_the_clock, process))
            elif isinstance(output, AskBody):
                self._answers.append(lambda: self._do(process, process.harness.bodied(True)))

    def _join(self, process: Process, request: bytes) -> None:
        ((reply, ok),) = self.stage.ask("join", NAME, request)
        assert ok, reply
        self._do(process, process.harness.accepted((encode(reply), JSON)))
        self._do(process, process.harness.measured_early())

    def _tell_the_clock(self, process: Process) -> None:
        ((reply, _),) = self.stage.ask("clock", "")
        self._do(process, process.harness.clocked([(encode(reply), JSON)]))

    def _carry(self) -> None:
        """Deliver the answers to the queries of the step before, and what the simulator has put since."""
        answers, self._answers = self._answers, []
        for answer in answers:
            answer()
        while self._heard < len(self.stage.sent):
            to, _kind, message, _ = self.stage.sent[self._heard]
            self._heard += 1
            if to != NAME or not self.is_linked or not isinstance(message, Measures | PowerInForce | Error):
                continue
            if isinstance(message, PowerInForce):
                self.powers.append(message)
            around = self.strangers(self, message.tick) if isinstance(message, Measures) else ()
            for one in (*around, message, *around):
                self._deliver(one)

    def _deliver(self, message: Record) -> None:
        payload: Payload = encode(message), JSON
        for process in self._processes:
            harness = process.harness
            if isinstance(message, Measures):
                self._do(process, harness.measured([payload]))
            elif isinstance(message, PowerInForce):
                self._do(process, harness.powered(payload))
            else:
                self._do(process, harness.erred(payload, self.stage.now))

    # ------------------------------------------------------------ time

    def tick(self) -> tuple[int, int]:
        """Let one tick pass; return its number, and the power at the left motor before the next one."""
        tick = self.stage.tick
        while self.stage.tick == tick:
            self._step()
        # The step from `tick` has begun. Until just before the next one:
        for _ in range(STEPS - 1):
            self._step()
        assert self.stage.tick == tick + 1
        return tick, self._controller.power[0]

    def _step(self) -> None:
        self.stage.work(STEP)
        self._carry()
        self._writer.step(self.stage.now)
        data, self._line.data = self._line.data, b""
        self._controller.step(STEP, data)
        if self._controller.power[0] != self.seen[-1]:
            self.seen.append(self._controller.power[0])
        now = self.stage.now
        self._line.waiting.append(reading(round(now / STEP), stamp=now, received=now))


def _forgeries(room: Room, tick: int) -> Sequence[Record]:
    """Return all that a stranger puts around the measures of a tick: full power, copies, and what made a chair deaf."""
    run, last = room.stage.live_run.state.run, room.powers[-1:]
    return (
        *(PowerInForce(run=run, tick=t, seq=t, left_motor=1.0, right_motor=-1.0, code="0" * 32) for t in (tick, LAST)),
        PowerInForce(run=run, tick=tick, left_motor=1.0, right_motor=-1.0),
        *room.powers[-40:-35],
        *(one for power in last for one in (power, msgspec.structs.replace(power, left_motor=1.0, right_motor=-1.0))),
        Measures(run=run, tick=LAST, time=1.0),
        *(Measures(run=STRANGER, tick=t, time=1.0) for t in (0, tick, LAST)),
        Error(run=run, tick=tick, code="deleted", text="deleted"),
    )


def _commands(ticks: Sequence[int]) -> list[int]:
    return [round(1000.0 * power_of(tick)) for tick in ticks]


def test_forged_power_and_forged_ticks_change_nothing_at_any_tick() -> None:
    room = Room()
    room.strangers = _forgeries
    passed = [room.tick() for _ in range(60)]
    # Before the next tick, the motors have the command that answers this tick's measures, and the bridge has answered.
    ticks = [tick for tick, _ in passed]
    assert [power for _, power in passed] == _commands(ticks)
    assert room.poses[-len(ticks) :] == [tick + 1 for tick in ticks]
    # At no 5 ms in between did they have another.
    assert room.seen[-len(ticks) :] == _commands(ticks)
    assert max(room.seen) == max(_commands(ticks))


@pytest.mark.parametrize("noticed", [True, False], ids=["noticed", "silent"])
@pytest.mark.parametrize("gap", [2, 4, 5, 7, 15, 61])
@pytest.mark.parametrize("attacked", [False, True])
def test_after_a_gap_the_first_measures_that_arrive_are_obeyed_in_their_tick(
    attacked: bool, gap: int, noticed: bool
) -> None:
    room = Room()
    room.strangers = _forgeries if attacked else room.strangers
    for _ in range(45):
        room.tick()
    room.cut(noticed=noticed)
    gone = [room.tick() for _ in range(gap)]
    # The bridge stops the motors 0.3 s after the last power.
    assert all(power == 0 for _, power in gone[6:])
    room.link(noticed=noticed)
    answered = len(room.poses)
    # The power of this tick's step arrives; its measures were put before, and are lost.
    room.tick()
    passed = [room.tick() for _ in range(5)]
    ticks = [tick for tick, _ in passed]
    assert ticks[0] == gone[-1][0] + 2
    assert [power for _, power in passed] == _commands(ticks)
    # After a second join it repeats its answer.
    assert list(dict.fromkeys(room.poses[answered:])) == [*ticks, ticks[-1] + 1]
    assert set(room.seen) <= {0, *_commands(range(ticks[-1] + 1))}


@pytest.mark.parametrize("ahead", [1, 2, 3])
def test_forged_ticks_just_ahead_cost_one_tick_at_most(ahead: int) -> None:
    room = Room()
    run = room.stage.live_run.state.run
    room.strangers = lambda _room, tick: (Measures(run=run, tick=tick + ahead, time=1.0),)
    passed = [room.tick() for _ in range(40)]
    # The first ones are believed until the clock answers. Then each tick's measures are obeyed before the next tick.
    lost = [tick for tick, power in passed if power != _commands([tick])[0]]
    assert len(lost) <= 1, lost
    assert len({tick + 1 for tick, _ in passed} - set(room.poses)) <= 1
