"""Keeps the agents of a crew joined to their simulator. No I/O: events go in, and what the caller must do comes out.

Each agent has a harness of its own. Here its events are taken out of the messages of the crew, and what all harnesses
want at a time is put together. An agent that is refused or whose mind fails ends alone; the crew goes on.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from intellwheels_agents.harness import Harness
from intellwheels_agents.harness_outputs import (
    AskBody,
    AskClock,
    Exit,
    Log,
    Output,
    Payload,
    Print,
    Publish,
    RequestJoin,
    RequestLeave,
)
from intellwheels_agents.mind import Bridge, Context, Make, Mind
from intellwheels_agents.mind_error import MindError
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.crew_messages import CrewPart, crew_join, crew_messages, for_crew, join_parts
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    AgentMeasures,
    CrewError,
    CrewJoined,
    Error,
    Joined,
    Map,
    Refused,
    Robot,
)

_COUNTED: Final = "counted "


@dataclass(frozen=True)
class CrewMember:
    """An agent of a crew.

    Attributes:
        robot: A document made by `robot_document.joining`, with the instance of the crew; it has a name.
        make: Makes its mind for each run.
        options: The options of its mind.
    """

    robot: Robot
    make: Make
    options: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class RequestCrewJoin:
    """Query `crew/<crew>/join` with this encoded `CrewJoin`, in which these agents are."""

    payload: bytes
    agents: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class RequestCrewLeave:
    """Query `crew/<crew>/leave` with this encoded `CrewLeave`."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class AskBodyOf:
    """Query `body/<agent>`."""

    agent: str


CrewOutput: TypeAlias = RequestCrewJoin | RequestCrewLeave | Publish | AskClock | AskBodyOf | Print | Log | Exit


class CrewHarness:
    """The agents of a crew.

    Args:
        crew: Name of the crew.
        instance: 16 hex digits, new for each process.
        members: Its agents, at least one and at most 250, each with another name.
        encoding: The encoding of messages to the simulator, which answers in the same one.
        fetch_map: Asks the simulator for its map. It is called once for each run.
        simulator: Where the simulator is looked for, as text for messages.
        retry_for: Seconds to look for the simulator before giving up.
    """

    def __init__(
        self,
        crew: str,
        instance: str,
        members: Sequence[CrewMember],
        *,
        encoding: Encoding = Encoding.JSON,
        fetch_map: Callable[[], Map],
        simulator: str = "the simulator",
        retry_for: float = math.inf,
    ) -> None:
        self._crew, self._instance, self._encoding = crew, instance, encoding
        self._fetch_map = fetch_map
        self._map: tuple[str, Map] | None = None
        self._failed = False
        self._error_counts: dict[str, int] = {}
        self._harnesses = {
            member.robot.name or "": Harness(
                member.robot,
                self._sharing_map(member.make),
                options=member.options,
                encoding=encoding,
                fetch_map=fetch_map,
                simulator=simulator,
                retry_for=retry_for,
                reads=AgentMeasures,
            )
            for member in members
        }
        self._here = dict(self._harnesses)

    @property
    def deadline(self) -> float | None:
        """When `wake` must be called, or None."""
        return min((each.deadline for each in self._here.values() if each.deadline is not None), default=None)

    # ------------------------------------------------------------ events

    def start(self, now: float) -> list[CrewOutput]:
        """Ask to join."""
        return self._each(lambda harness: harness.start(now))

    def wake(self, now: float) -> list[CrewOutput]:
        """Do what was due at `deadline`."""
        return self._each(lambda harness: harness.wake(now))

    def present(self, now: float) -> list[CrewOutput]:
        """Handle the appearance of a simulator."""
        return self._each(lambda harness: harness.present(now))

    def absent(self, now: float) -> list[CrewOutput]:
        """Handle the disappearance of the simulator, or of the connection to it."""
        return self._each(lambda harness: harness.absent(now))

    def joined(self, payload: Payload, agents: Sequence[str], now: float) -> list[CrewOutput]:
        """Handle the reply to a request to join in which these agents were."""
        try:
            joined = decode(CrewJoined, *payload, strict=False)
        except WireError as error:
            return [Log(f"dropped reply=join why={error.text!r}"), *self.unanswered(agents, now)]
        replies: dict[str, Joined | Refused] = {each.agent: each for each in joined.refused}
        for each in joined.joined:
            replies[each.agent] = Joined(
                run=joined.run, tick=joined.tick, session=each.session, parameters=joined.parameters,
                position=each.position, robot=each.robot,
            )  # fmt: skip

        def reply(agent: str, harness: Harness) -> list[Output]:
            found = replies.get(agent)
            if isinstance(found, Joined):
                return harness.accepted((encode(found), Encoding.JSON)) + harness.measured_early()
            if found is None:
                return harness.unanswered(now)
            return harness.refused((encode(Refused(code=found.code, text=found.text)), Encoding.JSON), now)

        return self._some(agents, reply)

    def refused(self, payload: Payload, agents: Sequence[str], now: float) -> list[CrewOutput]:
        """Handle the error reply to a request to join in which these agents were."""
        return self._some(agents, lambda _agent, harness: harness.refused(payload, now))

    def unanswered(self, agents: Sequence[str], now: float, denied: str = "") -> list[CrewOutput]:
        """Handle a request to join without an answer. `denied` says why the router did not let it through, if known."""
        return self._some(agents, lambda _agent, harness: harness.unanswered(now, denied))

    def measured(self, parts: Sequence[CrewPart], encoding: Encoding) -> list[CrewOutput]:
        """Handle parts of `CrewMeasures`, oldest first."""
        payloads: dict[str, list[Payload]] = {}
        for part in parts:
            for agent, data in part.measures.items():
                payloads.setdefault(agent, []).append((data, encoding))
        return self._some(payloads, lambda agent, harness: harness.measured(payloads[agent]))

    def clocked(self, payloads: Sequence[Payload]) -> list[CrewOutput]:
        """Handle the answers to a query for the clock."""
        return self._each(lambda harness: harness.clocked(payloads))

    def bodied(self, agent: str, is_here: bool) -> list[CrewOutput]:
        """Handle the answer to a query for the body of an agent."""
        return self._some((agent,), lambda _agent, harness: harness.bodied(is_here))

    def erred(self, payload: Payload, now: float) -> list[CrewOutput]:
        """Handle a `CrewError`."""
        try:
            error = decode(CrewError, *payload, strict=False)
        except WireError as wrong:
            return [Log(f"dropped message=CrewError why={wrong.text!r}")]
        own = encode(Error(**{name: getattr(error, name) for name in Error.__struct_fields__})), Encoding.JSON
        if error.code == "not-joined":
            # The simulator forgot us. It says so for a few agents only, and joining again changes nothing for the rest.
            return self._each(lambda harness: harness.erred(own, now))
        if error.agent is not None:
            return self._some((error.agent,), lambda _agent, harness: harness.erred(own, now))
        count = self._error_counts[error.code] = self._error_counts.get(error.code, 0) + 1
        if str(count).strip("0") != "1":
            return []
        return [Log(f"erred crew={self._crew} code={error.code} count={count} tick={error.tick} text={error.text!r}")]

    def stop(self) -> list[CrewOutput]:
        """Leave the simulation with all agents and end."""
        return self._each(lambda harness: harness.stop())

    # ------------------------------------------------------------ one for all

    def _each(self, event: Callable[[Harness], list[Output]]) -> list[CrewOutput]:
        return self._some(self._here, lambda _agent, harness: event(harness))

    def _some(self, agents: Iterable[str], event: Callable[[str, Harness], list[Output]]) -> list[CrewOutput]:
        """Give an event to some agents, and return what they want together."""
        wanted: list[tuple[str, Output]] = []
        for agent in list(agents):
            harness = self._here.get(agent)
            if harness is None:
                continue
            try:
                outputs = event(agent, harness)
            except MindError as error:
                # It leaves at once and prints no "left" line: this is a crash, of one mind of many.
                leaving = [output for output in harness.stop() if isinstance(output, RequestLeave)]
                outputs = [*leaving, Exit(1, str(error))]
            wanted += [(agent, output) for output in outputs]
        return self._together(wanted) if wanted else []

    def _together(self, wanted: Sequence[tuple[str, Output]]) -> list[CrewOutput]:
        robots: dict[str, bytes] = {}
        actions: list[bytes] = []
        leaves: list[bytes] = []
        lines: dict[str, list[str]] = {}
        found: list[CrewOutput] = []
        clock = False
        for agent, output in wanted:
            if isinstance(output, Publish):
                actions.append(for_crew(output.payload, agent, self._encoding))
            elif isinstance(output, RequestJoin):
                robots[agent] = output.payload
            elif isinstance(output, RequestLeave):
                leaves.append(for_crew(output.payload, agent, self._encoding))
            elif isinstance(output, AskClock):
                clock = True
            elif isinstance(output, AskBody):
                found.append(AskBodyOf(agent))
            elif isinstance(output, Print):
                found.append(output)
            elif isinstance(output, Log):
                if not output.line.startswith(_COUNTED):
                    lines.setdefault(output.line, []).append(agent)
            elif isinstance(output, Exit):
                self._end(agent, output.code)
                if output.text:
                    lines.setdefault(f"ended why={output.text!r}", []).append(agent)
        found += [Log(_with_agents(line, agents)) for line, agents in lines.items()]
        found += [Publish(data) for data in crew_messages("Actions", self._crew, actions, self._encoding)]
        found += [RequestCrewLeave(data) for data in crew_messages("Leave", self._crew, leaves, self._encoding)]
        names = list(robots)
        for part in join_parts(list(robots.values())):
            some, names = names[: len(part)], names[len(part) :]
            data = crew_join(self._crew, self._instance, part, self._encoding)
            found.append(RequestCrewJoin(data, tuple(some)))
        if clock:
            found.append(AskClock())
        if not self._here:
            found += [self._counts(), Exit(1 if self._failed else 0)]
        return found

    def _end(self, agent: str, code: int) -> None:
        self._here.pop(agent, None)
        self._failed = self._failed or code != 0

    def _counts(self) -> Log:
        every = self._harnesses.values()
        missed, repeated, errors = (
            sum(getattr(one, name) for one in every) for name in ("missed", "repeated", "errors")
        )
        return Log(f"{_COUNTED}agents={len(every)} missed={missed} repeated={repeated} errors={errors}")

    def _sharing_map(self, make: Make) -> Make:
        """Return a maker of minds that get the same map in the same run."""

        def made(context: Context) -> Mind | Bridge:
            return make(dataclasses.replace(context, fetch_map=lambda: self._map_of(context.run)))

        made.__doc__ = make.__doc__
        return made

    def _map_of(self, run: str) -> Map:
        if self._map is None or self._map[0] != run:
            self._map = run, self._fetch_map()
        return self._map[1]


def _with_agents(line: str, agents: Sequence[str]) -> str:
    """Return a line of the log that is about an agent, or about several that wrote the same."""
    verb, _, rest = line.partition(" ")
    who = f"agent={agents[0]}" if len(agents) == 1 else f"agents={len(agents)} first={agents[0]}"
    return f"{verb} {who} {rest}"
