"""The state that the parts of the service share, in objects that each hold what changes together.

`inbound` takes in puts, `joining` handles joins and leaves, `control` handles what operators ask for, `outbound`
publishes, and `live_run` moves the world.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from intellwheels_maps.turning import TurningCheck
from intellwheels_schemas import defaults
from intellwheels_schemas.file_records import Change
from intellwheels_schemas.messages import Pace, Parameters, Result, ResultCode
from intellwheels_server import world
from intellwheels_server.log.branch import Branch
from intellwheels_server.service.command_ages import CommandAges
from intellwheels_server.service.connected_agents import ConnectedAgents
from intellwheels_server.service.error_replies import UNASKED_BURST, UNASKED_RATE, ErrorLimit, MessageLimit
from intellwheels_server.service.floor_queue import FloorQueue
from intellwheels_server.service.input_latch import InputLatch
from intellwheels_server.service.load_floor import FloorWorker
from intellwheels_server.service.pacing import Pacing
from intellwheels_server.service.publisher import Outlet, Publisher
from intellwheels_server.service.roster import new_hex
from intellwheels_server.service.run_state import Recorder, RunState
from intellwheels_server.service.travelled_paths import TravelledPaths
from intellwheels_server.world import Outcome, Setup, Walls


@dataclass(frozen=True, kw_only=True)
class Options:
    """How the service runs.

    Attributes:
        world: The name of the world.
        setup: The setup of the world.
        pace: What makes a tick begin.
        speed: Simulated time over wall time, at pace `realtime`.
        expect: Agents whose minds must have joined before tick 0 is left.
        open_loop: Whether, at pace `free`, agents may join that want the simulator to wait for their answers.
        grace: Seconds until an agent whose token is gone is removed.
        agent_rays: Rays per second that the sensors of an agent may cast in real time.
        world_rays: Rays per second that all sensors together may cast in real time.
        deadline: Seconds lockstep waits for an answer.
        quit_at_end: Whether the service ends when the run ends.
        await_page: Whether the run starts paused, until a page opens or somebody resumes it.
        branch: The run that this one repeats at first, if any.
        hide_truth: Whether true poses stay off the network: the world is a laboratory (`truth_filter`).
        reserved: The place that is kept for each agent of the scene.
    """

    world: str
    setup: Setup
    pace: Pace = "realtime"
    speed: float = 1.0
    expect: tuple[str, ...] = ()
    open_loop: bool = False
    grace: float = defaults.GRACE
    agent_rays: int = defaults.AGENT_RAYS
    world_rays: int = defaults.WORLD_RAYS
    deadline: float = defaults.ELASTIC_DEADLINE
    quit_at_end: bool = False
    await_page: bool = False
    branch: Branch | None = None
    hide_truth: bool = False
    reserved: Mapping[str, str] = field(default_factory=dict)


@dataclass(slots=True)
class PlaybackProgress:
    """How far a playback is: the last tick of the run that is shown, and whether the log is at its end."""

    last_tick: int
    at_end: bool = False


class ServiceState:
    """The state of the service.

    Attributes:
        options: How the service runs.
        exit: The exit code of the process once the service is over, else None.
        run: The world, its hash and its log.
        pacing: When ticks begin.
        agents: The agents that have joined.
        latch: The messages of agents that act on the next step.
        command_ages: How late the commands of agents are, in a run that does not wait for them.
        travelled: How far the bodies have travelled and turned.
        message_limit: How many messages of a sender are read.
        error_limit: How many error replies a sender gets.
        unasked_limit: How many reports there are about input that nobody asked for, and about unknown keys.
        publisher: The outgoing side.
        floors: The requests to load a floor, and those that wait for them.
        turning_check: Where bodies cannot turn, on the floor of the last body that joined.
        playback: How far the playback is; None in a live run.
    """

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        floor_worker: FloorWorker,
        unix_time: Callable[[], float],
        record: Recorder | None = None,
        run: str | None = None,
    ) -> None:
        """Begin a run.

        Args:
            options: How the service runs.
            outlet: Where messages go.
            floor_worker: Loads the floors that operators ask for.
            unix_time: Returns Unix time in seconds, for stamps.
            record: Writes the input log; None for no log.
            run: The name of the run; random if not given.
        """
        self.options = options
        self.exit: int | None = None
        self.run = RunState(world.begin(options.setup, run or new_hex()), record)
        self.pacing = Pacing(options.pace, options.setup, speed=options.speed, deadline=options.deadline)
        self.agents = ConnectedAgents()
        self.latch = InputLatch()
        self.command_ages = CommandAges(options.setup.period)
        self.travelled = TravelledPaths()
        self.message_limit = MessageLimit()
        self.error_limit = ErrorLimit()
        self.unasked_limit = ErrorLimit(UNASKED_RATE, UNASKED_BURST)
        self.publisher = Publisher(outlet, unix_time, hide_truth=options.hide_truth)
        self.floors = FloorQueue(floor_worker)
        self.turning_check = TurningCheck(options.setup.floor)
        self.playback: PlaybackProgress | None = None
        self._queue: list[Callable[[float], None]] = []
        self._missed: str | None = None  # an expected agent that was not there lately

    # ------------------------------------------------------------ queries

    @property
    def has_queued_changes(self) -> bool:
        """Whether changes wait for a tick at which they may act."""
        return bool(self._queue)

    def is_stopped(self) -> bool:
        """Return whether no message that arrives can cause a step now."""
        return self.pacing.is_stopped(ended=self.run.state.ended)

    def may_change(self) -> bool:
        """Return whether changes may act now: not while answers are expected, unless the run is stopped."""
        return not self.pacing.lockstep or not self.pacing.barrier_open or self.is_stopped()

    def missing_agents(self) -> list[str]:
        """Return the expected agents that have not joined."""
        return [name for name in self.options.expect if self.agents.roster.mind(name) is None]

    def is_complete(self) -> bool:
        """Return whether all expected agents have joined. Most calls look for one of them only."""
        mind = self.agents.roster.mind
        if self._missed is not None and mind(self._missed) is None:
            return False
        self._missed = next((name for name in self.options.expect if mind(name) is None), None)
        return self._missed is None

    def result(self, code: ResultCode, text: str | None = None) -> Result:
        """Return a reply to a control message or a leave, with the current run, tick and hash."""
        return self.run.result(code, text)

    def parameters(self) -> Parameters:
        """Return what agents need to know of the simulation."""
        options, setup = self.options, self.run.state.setup
        return Parameters(
            world=options.world,
            period=setup.period,
            pace=options.pace,
            say_limit=setup.say_limit,
            say_range=setup.say_range,
            command_timeout=setup.command_timeout,
            grace=options.grace,
        )

    # ------------------------------------------------------------ changes

    def queue_change(self, request: Callable[[float], None]) -> None:
        """Call `request` with the time as soon as changes may act."""
        self._queue.append(request)

    @property
    def last_queued(self) -> Callable[[float], None] | None:
        """The last change in the queue, None if there is none."""
        return self._queue[-1] if self._queue else None

    def make_queued_changes(self, now: float) -> None:
        """Make the queued changes, and further ones that these queue."""
        while self._queue:
            queue, self._queue = self._queue, []
            for request in queue:
                request(now)

    def apply(self, change: Change, walls: Walls | None = None) -> Outcome:
        """Change the world, publish what happened and return the outcome.

        Args:
            change: The change.
            walls: The walls of its map, if it has one and they are cut already.
        """
        outcome, events = self.run.apply(change, walls)
        self.publisher.schedule.mark_changed()
        for event in events:
            self.publisher.put_event(event)
        return outcome

    def apply_all(self, changes: Sequence[Change]) -> tuple[Outcome, ...]:
        """Change the world several times, with one set of bodies made at the end; return the outcome of each change."""
        outputs = self.run.apply_all(changes)
        self.publisher.schedule.mark_changed()
        for event in outputs.events:
            self.publisher.put_event(event)
        return outputs.outcomes

    def answer_steps(self, code: ResultCode, text: str | None = None) -> None:
        """Answer the operator who asked for steps, if any, and make no more of them."""
        if self.pacing.steps is not None:
            steps, self.pacing.steps = self.pacing.steps, None
            steps.query.reply(self.result(code, text))

    def end_for_missed_answer(self, agent: str) -> None:
        """End a strict run, in which no answer may be missing."""
        self.publisher.outlet.print_line(f"miss agent={agent} tick={self.run.state.tick}")
        self.exit = 1
