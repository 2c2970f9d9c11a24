"""Worlds are advanced together as far as they fit, and as if each were alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_gym.scene_world import SceneWorld
from intellwheels_gym.world_batch import WorldBatch
from intellwheels_server.world import digest
from tests.gym.test_scene_world import noisy

GO = {"chair": (0.6, 0.5)}
LEAVER = """from intellwheels_agents import Actions, Context, Measures


class Mind:
    def __init__(self, context: Context) -> None:
        self.run = context.run

    def decide(self, measures: Measures) -> Actions:
        return Actions(leave=True) if measures.tick == 5 else Actions()
"""


def begun(world: SceneWorld, seed: str) -> SceneWorld:
    world.reset(seed)
    return world


def test_worlds_that_begin_again_pause_or_lose_a_body_go_on_as_if_alone(tmp_path: Path) -> None:
    (tmp_path / "leaver.py").write_text(LEAVER)
    together = [noisy(tmp_path), noisy(tmp_path), noisy(tmp_path, other="leaver.py")]
    alone = [noisy(tmp_path), noisy(tmp_path), noisy(tmp_path, other="leaver.py")]
    for k in range(3):
        begun(together[k], str(k))
        begun(alone[k], str(k))
    batch = WorldBatch(3)
    batch.advance({})
    for tick in range(12):
        if tick == 4:
            begun(together[0], "9")
            begun(alone[0], "9")
        moved = [k for k in range(3) if (k, tick) != (1, 7)]
        batch.advance({k: (together[k], GO) for k in moved})
        for k in moved:
            alone[k].advance(GO)
        assert [digest(one.state) for one in together] == [digest(one.state) for one in alone]
    assert together[2].state.names == ("chair",)
    assert [one.state.tick for one in together] == [8, 11, 12]


def test_mind_that_fails_is_named_and_no_world_moves(tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text(LEAVER.replace("Actions(leave=True) if", "1 / 0 if"))
    worlds = [begun(noisy(tmp_path, other="broken.py"), str(k)) for k in range(2)]
    batch = WorldBatch(2)
    for _ in range(5):
        batch.advance({k: (worlds[k], GO) for k in range(2)})
    with pytest.raises(ZeroDivisionError) as failure:
        batch.advance({k: (worlds[k], GO) for k in range(2)})
    assert "raised by the mind of agent 'table'" in failure.value.__notes__
    assert [one.state.tick for one in worlds] == [5, 5]
