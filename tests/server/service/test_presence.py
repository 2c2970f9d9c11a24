from __future__ import annotations

import msgspec

from intellwheels_maps import robot
from intellwheels_schemas.messages import Joined, Record, Refused
from intellwheels_server.service.joining import TOKEN_WAIT
from tests.server.stage import Stage


def asked(stage: Stage) -> list[tuple[Record, bool]]:
    """Ask to join before the token is there."""
    chair = msgspec.structs.replace(robot("rear-wheel"), name="chair1", instance="a" * 16, format=None)
    return stage.ask("join", "chair1", chair)


def test_a_join_waits_for_its_token() -> None:
    stage = Stage()
    replies = asked(stage)
    stage.work(0.5 * TOKEN_WAIT)
    assert replies == []
    stage.token("chair1", "both", "a" * 16)
    assert isinstance(replies[0][0], Joined)


def test_a_join_whose_token_does_not_come_is_refused() -> None:
    stage = Stage()
    replies = asked(stage)
    stage.work(2.0 * TOKEN_WAIT)
    refused, ok = replies[0]
    assert isinstance(refused, Refused)
    assert (refused.code, ok) == ("no-token", False)


def test_a_token_that_goes_and_comes_again_is_noted() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    instance = stage.live_run._service.agents.roster.members("chair1")[0].instance
    stage.token("chair1", "both", instance, present=False)
    stage.token("chair1", "both", instance)
    assert stage.events()[-2:] == ["lost", "returned"]
