"""The points about how Actions are put, against programs with one fault."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from intellwheels_experiments.conformance.agent_session import SAY_LIMIT
from intellwheels_experiments.conformance.probe import ActionsPut
from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Actions, Measures
from tests.every_case import every_case
from tests.experiments.conformance.programs import Program, only_failure


class WithoutRun(Program):
    """Names no run."""

    def act(self, actions: Actions) -> None:
        super().act(replace(actions, run=None))


class WithoutSession(Program):
    """Names no session."""

    def act(self, actions: Actions) -> None:
        super().act(replace(actions, session=None))


class Labelled(Program):
    """Puts JSON under another encoding."""

    def __init__(self, label: str) -> None:
        super().__init__()
        self.label = label

    def act(self, actions: Actions) -> None:
        self.events.append(ActionsPut(encode(actions), self.label))


class Blocks(Program):
    """Puts with the congestion control block."""

    def act(self, actions: Actions) -> None:
        self.events.append(ActionsPut(encode(actions), "application/json", blocks=True))


class TalksTooMuch(Program):
    """Says more than the limit."""

    def act(self, actions: Actions) -> None:
        super().act(replace(actions, say="x" * (SAY_LIMIT + 1)))


class Repeats(Program):
    """Says what it hears, with a few words before."""

    def on_measures(self, measures: Measures) -> None:
        self.heard = "".join(message.text for message in measures.message if len(message.text) <= SAY_LIMIT)
        super().on_measures(measures)

    def act(self, actions: Actions) -> None:
        super().act(replace(actions, say=f"I heard {self.heard}" if self.heard.startswith("xxx") else None))


@every_case(
    ("program", "point", "expected", "got"),
    [
        (WithoutRun(), "names", "Actions with Tick, Run and Session", 'no Run: {"Session"'),
        (WithoutSession(), "names", "Actions with Tick, Run and Session", 'no Session: {"Run"'),
        (Labelled("text/plain"), "encoding", "application/json for JSON", "text/plain"),
        (Labelled("application/xml"), "encoding", "application/json for JSON", "application/xml"),
        (Labelled("application/json;iw.v2"), "encoding", "application/json for JSON", "application/json;iw.v2"),
        (Labelled("zenoh/bytes"), "encoding", "application/json for JSON", "zenoh/bytes"),
        (Blocks(), "congestion", "the congestion control drop", "block"),
        (TalksTooMuch(), "say", "a Say of at most 100 characters", "101: xxx"),
        (Repeats(), "say", "a Say of at most 100 characters", "108: I heard xxx"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Program) else None,
)
def test_fault_fails_its_point_only(program: Program, point: str, expected: str, got: str) -> None:
    failure = only_failure(program)
    assert failure.point == point
    assert expected in failure.expected
    assert failure.got.startswith(got)


def test_encoding_with_the_version_passes() -> None:
    program = Labelled("application/json;iw.v1")
    with pytest.raises(ValueError, match="not enough values"):
        only_failure(program)
