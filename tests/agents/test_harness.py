"""The harness as a state table: events in, outputs out."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import pytest

from intellwheels_agents.harness import NAME_TAKEN, Harness, Phase
from intellwheels_agents.harness_outputs import (
    AskBody,
    AskClock,
    Exit,
    Log,
    Output,
    Print,
    Publish,
    RequestJoin,
    RequestLeave,
)
from intellwheels_agents.mind import Context
from intellwheels_agents.mind_error import MindError
from intellwheels_agents.options import OptionError
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import (
    Actions,
    Clock,
    Error,
    ErrorCode,
    Heard,
    Joined,
    Leave,
    Measures,
    Parameters,
    Pose,
    Position,
    Power,
    PowerInForce,
    Record,
    Refused,
    RefusedCode,
    Robot,
    Role,
)
from intellwheels_schemas.metal_codes import code_of, pose_line, power_line
from tests.every_case import every_case

RUN, OTHER_RUN = "a" * 16, "b" * 16
SESSION, OTHER_SESSION = "c" * 16, "d" * 16
ROBOT = Robot(name="chair1", instance="0" * 16, top_speed=1.0, length=1.0, width=0.6)
JSON = Encoding.JSON


class Recorder:
    """A mind that gives a fixed answer and records what it saw."""

    def __init__(self, answer: Actions | Pose) -> None:
        self.answer = answer
        self.contexts: list[Context] = []
        self.seen: list[Measures] = []
        self.powers: list[PowerInForce] = []

    def make(self, context: Context) -> Recorder:
        self.contexts.append(context)
        return self

    def decide(self, measures: Measures) -> Actions:
        self.seen.append(measures)
        return self.answer  # type: ignore[return-value]

    def obey(self, power: PowerInForce) -> None:
        self.powers.append(power)


def bytes_of(message: Record) -> tuple[bytes, Encoding]:
    return encode(message, JSON), JSON


def measures(tick: int, run: str = RUN, **fields: object) -> tuple[bytes, Encoding]:
    return bytes_of(Measures(run=run, tick=tick, time=tick * 0.05, **fields))  # type: ignore[arg-type]


KEY = "0f" * 32


def joined(run: str = RUN, session: str = SESSION, key: str | None = None) -> tuple[bytes, Encoding]:
    parameters = Parameters(
        world="main", period=0.05, pace="lockstep", say_limit=5, say_range=8.0, command_timeout=0.5, grace=3.0
    )
    return bytes_of(
        Joined(
            run=run,
            tick=0,
            session=session,
            parameters=parameters,
            position=Position(x=1.0, y=2.0, heading=0.0),
            robot=ROBOT,
            key=key,
        )
    )


def coded(seq: int, left: float = 0.1, key: str = KEY) -> tuple[bytes, Encoding]:
    power = PowerInForce(run=RUN, tick=3, seq=seq, left_motor=left, right_motor=0.2)
    return bytes_of(msgspec.structs.replace(power, code=code_of(key, power_line(power))))


def clock(tick: int, run: str = RUN) -> tuple[bytes, Encoding]:
    return bytes_of(
        Clock(run=run, tick=tick, time=tick * 0.05, state="running", pace="lockstep", hash="0" * 16, stamp=0.0)
    )


def refused(code: RefusedCode) -> tuple[bytes, Encoding]:
    return bytes_of(Refused(code=code, text="because"))


def error(code: ErrorCode) -> tuple[bytes, Encoding]:
    return bytes_of(Error(run=RUN, tick=3, code=code, text="words"))


def kinds(outputs: Sequence[Output]) -> list[str]:
    return [type(output).__name__ for output in outputs]


def put(outputs: Sequence[Output]) -> Actions:
    (payload,) = [output.payload for output in outputs if isinstance(output, Publish)]
    return decode(Actions, payload, JSON)


def joined_harness(mind: Recorder, **settings: object) -> Harness:
    harness = Harness(ROBOT, mind.make, **settings)  # type: ignore[arg-type]
    harness.start(0.0)
    harness.accepted(joined())
    return harness


@pytest.fixture
def mind() -> Recorder:
    return Recorder(Actions(left_motor=0.5, right_motor=0.25))


def test_harness_asks_at_once_and_reports_that_it_joined(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    (ask,) = harness.start(0.0)
    assert isinstance(ask, RequestJoin)
    assert decode(Robot, ask.payload, JSON) == ROBOT
    assert harness.accepted(joined()) == [Print(f"joined agent=chair1 run={RUN} tick=0")]
    assert harness.phase is Phase.JOINED
    (context,) = mind.contexts
    assert (context.agent, context.position.x, context.parameters.say_limit) == ("chair1", 1.0, 5)


def test_answer_carries_run_session_tick_and_sequence_number(mind: Recorder) -> None:
    harness = joined_harness(mind)
    first, second = put(harness.measured([measures(0)])), put(harness.measured([measures(1)]))
    assert (first.run, first.session, first.tick, first.seq) == (RUN, SESSION, 0, 0)
    assert (second.tick, second.seq, second.left_motor, second.right_motor) == (1, 1, 0.5, 0.25)


def test_repeated_tick_gets_the_same_bytes_again(mind: Recorder) -> None:
    harness = joined_harness(mind)
    once = harness.measured([measures(0)])
    assert harness.measured([measures(0)]) == once
    # The same tick with other bytes counts as repeated too.
    assert harness.measured([(measures(0)[0] + b" ", JSON)]) == once
    assert harness.repeated == 2
    assert len(mind.seen) == 1


def test_older_tick_is_not_answered(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(5)])
    assert harness.measured([measures(4)]) == []


def test_newest_of_several_ticks_is_answered_with_all_messages_heard(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(0)])
    heard = [Heard(sender="door", tick=tick, distance=1.0, text=str(tick)) for tick in range(3)]
    came = [measures(1, message=(heard[0],)), measures(3, message=(heard[1], heard[2]))]
    assert put(harness.measured(came)).tick == 3
    assert mind.seen[-1].message == tuple(heard)
    assert harness.missed == 2


def test_new_run_gets_a_new_mind_and_the_old_run_is_ignored(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(0)])
    assert harness.measured([measures(0, OTHER_RUN)]) == [AskClock()]
    outputs = harness.clocked([clock(0, OTHER_RUN)])
    assert outputs[0] == Print(f"run agent=chair1 run={OTHER_RUN}")
    answer = put(outputs)
    assert (answer.run, answer.session, answer.tick, answer.seq) == (OTHER_RUN, SESSION, 0, 0)
    assert len(mind.contexts) == 2
    assert harness.measured([measures(1)]) == []


LAST = 2**53 - 1
FORGED = [
    measures(0, OTHER_RUN),
    measures(40),
    bytes_of(Measures(run=RUN, tick=LAST, time=1.0)),
    bytes_of(Measures(run=OTHER_RUN, tick=LAST, time=1.0)),
]


@pytest.mark.parametrize("forged", FORGED)
@pytest.mark.parametrize("answers", [[clock(3)], [clock(3), clock(40, OTHER_RUN)], []])
def test_forged_measures_make_nobody_deaf(
    mind: Recorder, forged: tuple[bytes, Encoding], answers: list[tuple[bytes, Encoding]]
) -> None:
    harness = joined_harness(mind)
    for tick in range(3):
        harness.measured([measures(tick)])
    assert harness.measured([forged]) == [AskClock()]
    assert put(harness.measured([measures(3), forged])).tick == 3, "the real ones count meanwhile"
    assert kinds(harness.clocked(answers)) == ["Log"]
    assert put(harness.measured([measures(4)])).tick == 4
    assert len(mind.contexts) == 1


def test_gap_that_the_clock_confirms_is_answered(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(0)])
    assert harness.measured([measures(300)]) == [AskClock()]
    assert harness.measured([measures(301)]) == [], "one query at a time"
    assert put(harness.clocked([clock(302)])).tick == 301
    assert put(harness.measured([measures(302)])).tick == 302
    assert harness.clocked([clock(303)]) == []


@pytest.mark.parametrize("forged", FORGED[2:])
def test_forged_measures_after_a_gap_make_nobody_deaf(mind: Recorder, forged: tuple[bytes, Encoding]) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(0)])
    assert harness.measured([forged, measures(300), forged]) == [AskClock()]
    outputs = harness.clocked([clock(300)])
    assert kinds(outputs) == ["Log", "Publish"]
    assert put(outputs[1:]).tick == 300
    # Also when only forged ones came before the answer of the clock, the next real ones count.
    assert harness.measured([forged]) == [AskClock()]
    assert kinds(harness.clocked([clock(400)])) == []
    assert put(harness.measured([forged, measures(401)])).tick == 401


def test_long_queue_of_ticks_is_no_gap(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(0)])
    assert put(harness.measured([measures(tick) for tick in range(1, 200)])).tick == 199


def test_unknown_fields_are_ignored(mind: Recorder) -> None:
    harness = joined_harness(mind)
    payload = measures(0)[0][:-1] + b',"Humidity":0.4}'
    assert put(harness.measured([(payload, JSON)])).tick == 0


def test_measures_before_the_reply_are_answered_after_it(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    assert harness.measured([measures(0)]) == []
    # The agent has said that it joined before its mind decides, which may take long.
    assert kinds(harness.accepted(joined())) == ["Print"]
    assert kinds(harness.measured_early()) == ["Publish"]
    assert harness.measured_early() == []


def test_of_the_measures_that_came_while_the_mind_was_made_the_newest_is_answered(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    harness.measured([measures(0)])
    harness.accepted(joined())
    outputs = harness.measured_early([measures(1), measures(2)])
    assert kinds(outputs) == ["Publish"]
    assert put(outputs).tick == 2
    assert put(harness.measured_early([measures(3)])).tick == 3


def test_undecodable_measures_are_dropped_and_counted(mind: Recorder) -> None:
    harness = joined_harness(mind)
    assert kinds(harness.measured([(b"{", JSON)])) == ["Log"]
    assert harness.errors == 1
    assert put(harness.measured([measures(0)])).tick == 0


@pytest.mark.parametrize(("given", "sent"), [(1.5, 1.0), (-7.0, -1.0), (0.3, 0.3), (float("inf"), 1.0)])
def test_powers_are_clamped(given: float, sent: Power) -> None:
    harness = joined_harness(Recorder(Actions(left_motor=given, right_motor=None)))
    answer = put(harness.measured([measures(0)]))
    assert (answer.left_motor, answer.right_motor) == (sent, None)


def test_power_that_is_not_a_number_is_a_bug_of_the_mind() -> None:
    harness = joined_harness(Recorder(Actions(left_motor=float("nan"))))
    with pytest.raises(MindError, match="expected a number for left_motor, got nan"):
        harness.measured([measures(0)])


def test_message_is_cut_to_the_say_limit() -> None:
    harness = joined_harness(Recorder(Actions(say="follow me")))
    assert put(harness.measured([measures(0)])).say == "follo"


def test_option_that_the_mind_does_not_read_is_refused(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make, options={"sped": "1"})
    harness.start(0.0)
    with pytest.raises(OptionError, match="option sped"):
        harness.accepted(joined())


def test_missing_simulator_is_retried_each_second_and_logged_once(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    assert harness.unanswered(0.1) == [Log("waiting why='no simulator at the simulator, or not allowed'")]
    assert harness.deadline == pytest.approx(1.1)
    assert harness.wake(1.0) == []
    assert kinds(harness.wake(1.2)) == ["RequestJoin"]
    assert harness.unanswered(1.3) == []


def test_denial_is_logged_in_place_of_a_missing_simulator(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make, retry_for=2.0)
    harness.start(0.0)
    denied = "student1 may not be the mind of 'lab1' in world main, nobody there"
    assert harness.unanswered(0.5, denied) == [Log(f"waiting why={denied!r}")]
    harness.wake(1.5)
    assert harness.unanswered(1.6, denied) == [Exit(1, denied)]


def test_simulator_that_appears_is_asked_at_once(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    harness.unanswered(0.1)
    assert kinds(harness.present(0.2)) == ["RequestJoin"]


def test_harness_gives_up_after_retry_for(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make, retry_for=2.0)
    harness.start(0.0)
    harness.unanswered(0.5)
    harness.wake(1.5)
    assert harness.unanswered(1.6) == [Exit(1, "no simulator at the simulator, or not allowed")]


def test_mind_without_a_body_tries_again(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    assert kinds(harness.refused(refused("no-body"), 0.1)) == ["Log"]
    assert harness.deadline == pytest.approx(1.1)


def test_missing_token_is_retried_soon(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    harness.refused(refused("no-token"), 0.1)
    assert harness.deadline == pytest.approx(0.2)


@pytest.mark.parametrize("code", ["already-here", "no-place", "truth"])
def test_other_refusals_end_the_agent_with_the_simulators_text(mind: Recorder, code: RefusedCode) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    (end,) = harness.refused(refused(code), 0.1)
    assert end == Exit(NAME_TAKEN if code == "already-here" else 1, f"refused ({code}): because")
    assert harness.phase is Phase.OVER


@pytest.mark.parametrize("code", ["not-joined", "session"])
def test_forgotten_agent_joins_again(mind: Recorder, code: ErrorCode) -> None:
    harness = joined_harness(mind)
    harness.erred(error(code), 5.0)
    assert kinds(harness.wake(5.0)) == ["RequestJoin"]
    # Until the reply comes it answers with the old session, and errors do not ask again.
    assert put(harness.measured([measures(0)])).session == SESSION
    harness.erred(error(code), 5.1)
    assert harness.wake(5.1) == []
    harness.accepted(joined(session=OTHER_SESSION))
    assert put(harness.measured([measures(1)])).session == OTHER_SESSION
    assert len(mind.contexts) == 2


def test_deleted_agent_says_so_and_does_not_join_again(mind: Recorder) -> None:
    harness = joined_harness(mind)
    assert harness.erred(error("deleted"), 5.0) == [AskBody()]
    outputs = harness.bodied(False)
    assert outputs == [Print("removed agent=chair1 reason=deleted"), Log("words")]
    assert harness.phase is Phase.REMOVED
    for code in ("deleted", "not-joined", "session"):
        harness.erred(error(code), 6.0)
    assert harness.deadline is None
    assert harness.wake(100.0) == harness.measured([measures(4)]) == harness.present(7.0) == []
    harness.absent(8.0)
    assert harness.present(9.0) == []
    assert harness.stop() == [Exit(0)]


def test_agent_whose_body_is_here_was_not_deleted(mind: Recorder) -> None:
    harness = joined_harness(mind)
    assert harness.erred(error("deleted"), 5.0) == [AskBody()]
    assert harness.erred(error("deleted"), 5.1) == []
    assert kinds(harness.bodied(True)) == ["Log"]
    assert put(harness.measured([measures(0)])).tick == 0


def test_deletion_in_another_run_is_not_ours(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.erred(bytes_of(Error(run=OTHER_RUN, tick=3, code="deleted", text="words")), 5.0)
    assert harness.phase is Phase.JOINED


def test_errors_just_after_a_join_cause_no_join_loop(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.erred(error("session"), 0.2)
    assert harness.wake(0.3) == []
    assert kinds(harness.wake(1.0)) == ["RequestJoin"]


def test_other_errors_are_logged(mind: Recorder) -> None:
    harness = joined_harness(mind)
    assert harness.erred(error("late"), 1.0) == [Log("erred code=late count=1 tick=3 text='words'")]
    assert harness.phase is Phase.JOINED


@every_case(("role", "other"), [("body", "Actions"), ("mind", "Pose"), ("both", "Pose")])
@every_case("code", ["role", "session", "not-joined"])
def test_an_error_of_the_other_process_of_an_agent_is_not_ours(role: Role, other: str, code: ErrorCode) -> None:
    """Body and mind hear the same errors. A body that joined again for its mind's error would hold its chair."""
    answer = Pose(x=0.0, y=0.0, heading=0.0) if role == "body" else Actions()
    harness = Harness(msgspec.structs.replace(ROBOT, role=role), Recorder(answer).make)
    harness.start(0.0)
    harness.accepted(joined())
    for where in (other, f"{other}.Tick"):
        text = f"{where}: not for this role"
        assert harness.erred(bytes_of(Error(run=RUN, tick=3, code=code, where=where, text=text)), 5.0) == []
    assert (harness.phase, harness.errors) == (Phase.JOINED, 0)
    own = "Pose" if role == "body" else "Actions"
    assert harness.erred(bytes_of(Error(run=RUN, tick=3, code="late", where=own, text="words")), 5.0) != []


def test_error_at_every_tick_does_not_fill_the_log(mind: Recorder) -> None:
    harness = joined_harness(mind)
    noted = [harness.erred(error("late"), 1.0) for _ in range(100)]
    assert [index for index, notes in enumerate(noted, 1) if notes] == [1, 10, 100]
    assert harness.errors == 100


@pytest.mark.parametrize(("barrier", "answered"), [(True, ["Publish"]), (False, [])])
def test_empty_answer_is_published_only_if_a_lockstep_waits_for_it(barrier: bool, answered: list[str]) -> None:
    harness = Harness(msgspec.structs.replace(ROBOT, barrier=barrier), Recorder(Actions()).make)
    harness.start(0.0)
    harness.accepted(joined())
    assert kinds(harness.measured([measures(0)])) == answered


def test_returning_simulator_is_rejoined_and_the_run_keeps_its_mind(mind: Recorder) -> None:
    harness = joined_harness(mind)
    assert harness.present(1.0) == []
    harness.absent(2.0)
    assert kinds(harness.present(3.0)) == ["RequestJoin"]
    harness.accepted(joined())
    assert len(mind.contexts) == 1


def test_restarted_simulator_gets_a_new_mind(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.measured([measures(0)])
    harness.absent(2.0)
    harness.present(3.0)
    harness.accepted(joined(OTHER_RUN, OTHER_SESSION))
    assert put(harness.measured([measures(0, OTHER_RUN)])).tick == 0
    assert len(mind.contexts) == 2


def test_new_run_before_the_reply_waits_for_the_new_session(mind: Recorder) -> None:
    harness = joined_harness(mind)
    harness.absent(2.0)
    harness.present(3.0)
    assert harness.measured([measures(3, OTHER_RUN)]) == []
    assert kinds(harness.accepted(joined(OTHER_RUN, OTHER_SESSION))) == ["Print"]
    outputs = harness.measured_early()
    assert kinds(outputs) == ["Publish"]
    assert (put(outputs).tick, put(outputs).session) == (3, OTHER_SESSION)


def test_lost_simulator_is_given_up_after_retry_for(mind: Recorder) -> None:
    harness = joined_harness(mind, retry_for=10.0)
    harness.absent(2.0)
    assert harness.wake(11.9) == []
    assert kinds(harness.wake(12.0)) == ["Exit"]


def test_stop_leaves(mind: Recorder) -> None:
    harness = joined_harness(mind)
    outputs = harness.stop()
    assert kinds(outputs) == ["RequestLeave", "Log", "Print", "Exit"]
    assert isinstance(outputs[0], RequestLeave)
    assert decode(Leave, outputs[0].payload, JSON) == Leave(run=RUN, session=SESSION)
    assert outputs[2:] == [Print("left agent=chair1"), Exit(0)]
    assert harness.stop() == []


def test_stop_before_joining_sends_nothing(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    harness.start(0.0)
    assert harness.stop() == [Exit(0)]


def test_mind_leaves_with_its_last_actions() -> None:
    harness = joined_harness(Recorder(Actions(leave=True)))
    outputs = harness.measured([measures(0)])
    assert kinds(outputs) == ["Publish", "RequestLeave", "Log", "Print", "Exit"]
    assert put(outputs).leave


def test_body_answers_with_its_pose_and_obeys_power() -> None:
    body = Recorder(Pose(x=3.0, y=4.0, heading=0.5))
    harness = joined_harness(body)
    (output,) = harness.measured([measures(3)])
    assert isinstance(output, Publish)
    pose = decode(Pose, output.payload, JSON)
    assert (pose.x, pose.tick, pose.session) == (3.0, 3, SESSION)
    assert kinds(harness.powered(coded(1))) == ["Log"], "without a key no power counts"
    harness.accepted(joined())
    assert body.powers == []


def test_bridge_codes_its_poses_and_obeys_only_coded_powers() -> None:
    body = Recorder(Pose(x=3.0, y=4.0, heading=0.5))
    harness = Harness(ROBOT, body.make)
    harness.start(0.0)
    harness.accepted(joined(key=KEY))
    (output,) = harness.measured([measures(0)])
    assert isinstance(output, Publish)
    pose = decode(Pose, output.payload, JSON)
    assert pose.code == code_of(KEY, pose_line(pose))
    harness.powered(coded(1))
    for forged in (
        coded(2, key="00" * 32),
        coded(1),
        bytes_of(PowerInForce(run=RUN, tick=3, left_motor=1.0, right_motor=1.0)),
    ):
        harness.powered(forged)
    harness.powered(coded(2, 0.3))
    assert [power.left_motor for power in body.powers] == [0.1, 0.3]


def test_bridge_whose_key_was_lost_joins_again_as_a_new_process() -> None:
    body = Recorder(Pose(x=3.0, y=4.0, heading=0.5))
    harness = Harness(msgspec.structs.replace(ROBOT, type="real", role="body", instance="1" * 16), body.make)
    harness.start(0.0)
    assert kinds(harness.accepted(joined())) == ["Log", "Reappear", "RequestJoin"]
    here = bytes_of(Refused(code="already-here", text="agent 'chair1' is already here"))
    assert kinds(harness.refused(here, 1.0)) == ["Log"], "the simulator has not heard that the old token is gone"
    assert kinds(harness.wake(2.0)) == ["RequestJoin"]
    assert kinds(harness.accepted(joined(session="f" * 16, key=KEY))) == ["Print"]
    harness.powered(coded(1))
    assert len(body.powers) == 1


def test_body_without_a_mind_publishes_no_actions(mind: Recorder) -> None:
    harness = Harness(msgspec.structs.replace(ROBOT, role="body"), mind.make)
    harness.start(0.0)
    harness.accepted(joined())
    assert harness.measured([measures(0)]) == []


def test_xml_is_answered_in_xml(mind: Recorder) -> None:
    harness = joined_harness(mind, encoding=Encoding.XML)
    payload = encode(Measures(run=RUN, tick=0, time=0.0), Encoding.XML), Encoding.XML
    (output,) = harness.measured([payload])
    assert isinstance(output, Publish)
    assert output.payload.startswith(b"<Actions ")


def test_repeated_tick_without_an_answer_is_not_answered_with_an_older_one(mind: Recorder) -> None:
    harness = Harness(msgspec.structs.replace(ROBOT, barrier=False), mind.make)
    harness.start(0.0)
    harness.accepted(joined())
    harness.measured([measures(0)])
    mind.answer = Actions()  # nobody waits for it, so nothing is sent
    assert harness.measured([measures(1)]) == []
    assert harness.measured([measures(1)]) == []


def test_each_new_reason_to_wait_is_said_once(mind: Recorder) -> None:
    harness = Harness(ROBOT, mind.make)
    said = harness.start(0.0)
    for now, words in ((1.0, "no-token"), (2.0, "no-body"), (3.0, "no-body"), (4.0, "")):
        said += harness.refused(refused(words), now) if words else harness.unanswered(now)  # type: ignore[arg-type]
        said += harness.wake(now + 1.0)
    assert [output.line for output in said if isinstance(output, Log)] == [
        "waiting why='refused (no-token): because'",
        "waiting why='refused (no-body): because'",
        "waiting why='no simulator at the simulator, or not allowed'",
    ]
