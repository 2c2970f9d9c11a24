"""Costly maps never stop the world: ticks go on, each request is answered, and a signal is obeyed."""

from __future__ import annotations

import json
import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from intellwheels_schemas import defaults
from tests.e2e.costly_maps import MOST_CORNERS, SHAPES, crowded, load
from tests.e2e.stage import JSON, Peer, Stage

pytestmark = pytest.mark.process

PATIENCE = 5.0
"""How many times the promised time a test waits."""
QUICK = 3_000


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    with Stage(tmp_path, "costly") as stage:
        stage.server("--map", "square")
        yield stage


def ask(peer: Peer, wanted: dict[str, Any]) -> dict[str, Any]:
    """Ask for a load and return its result, which must come in time."""
    began = time.monotonic()
    (result,) = peer.ask("ctl/load", wanted)
    assert time.monotonic() - began < PATIENCE * defaults.LOAD_TIME
    return dict(result)


def test_maps_of_every_shape_are_loaded_or_refused_in_words(stage: Stage) -> None:
    with stage.peer() as peer:
        for number, shape in enumerate(SHAPES):
            result = ask(peer, load(shape, QUICK, number))
            if result["Code"] == "ok":
                assert shape != "knot"
                assert peer.clock()["Run"] == result["Run"]
            else:
                assert "expected" in result["Text"] or "crosses itself" in result["Text"], result
        end_during_a_load(stage, peer)


def test_world_goes_on_while_a_map_takes_longer_than_it_may(stage: Stage) -> None:
    with stage.peer() as peer:
        before = peer.clock()
        result = ask(peer, crowded(3_000))
        assert result["Code"] == "failed"
        assert result["Text"].startswith("Load: expected a map that is ready within")
        assert result["Run"] == before["Run"]
        assert result["Tick"] > before["Tick"] + 1
        assert ask(peer, {"Name": "corner"})["Code"] == "ok"


def loads_asked(stage: Stage) -> int:
    return stage.log(stage.simulator).count("asked verb=load")


def end_during_a_load(stage: Stage, peer: Peer) -> None:
    """End the simulator while it loads a map; it must obey at once."""
    wanted, asked = json.dumps(crowded(3_000)).encode(), loads_asked(stage)
    replies = peer.session.get(f"{peer.prefix}ctl/load", payload=wanted, encoding=JSON)
    stage.wait(lambda: loads_asked(stage) > asked or None, "the request", unless=stage.simulator)
    peer.ticks_on(2)
    stage.signal(stage.simulator, signal.SIGTERM)
    assert stage.exit(stage.simulator, PATIENCE * 1.0) == 0
    del replies


@pytest.mark.soak
def test_two_hundred_costly_maps(stage: Stage) -> None:
    chance = random.Random(200)
    with stage.peer() as peer:
        for number in range(200):
            shape = chance.choice([*SHAPES, "crowded"])
            before = peer.clock()
            wanted = crowded(2_500) if shape == "crowded" else load(shape, chance.randrange(100, MOST_CORNERS), number)
            result = ask(peer, wanted)
            assert result["Code"] in ("ok", "failed"), (shape, number)
            if result["Run"] == before["Run"]:
                assert result["Tick"] >= before["Tick"]
            peer.ticks_on(1)
        end_during_a_load(stage, peer)
