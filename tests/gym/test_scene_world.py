"""The world of a task is the world of the scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_gym.scene_world import SceneWorld
from intellwheels_gym.task import load_task
from intellwheels_maps import names, scene
from tests.agents.arena import Arena
from tests.every_case import every_case
from tests.gym.test_task import made

POWERS = (0.5, 0.5)


@every_case("name", names("scenes"))
def test_every_shipped_scene_begins_and_moves(name: str) -> None:
    world = SceneWorld(made(name))
    world.reset("3")
    before = {learner: world.pose(learner) for learner in world.learners}
    for _ in range(10):
        world.advance(dict.fromkeys(world.learners, POWERS))
    assert all(world.pose(learner) != pose for learner, pose in before.items())


def test_run_is_the_one_of_the_scene_to_the_bit() -> None:
    # The mind of the scene's chair is `drive` with the same powers.
    arena, world = Arena.of(scene("door"), seed="7"), SceneWorld(load_task("door"))
    world.reset("7")
    for _ in range(60):
        arena.step()
        world.advance({"chair": POWERS})
    assert world.state.numbers.tolist() == arena.state.numbers.tolist()
    assert world.measures("chair").sensors == arena_sensors(arena)


def arena_sensors(arena: Arena) -> object:
    from intellwheels_server.world import measures

    return measures(arena.state, "chair").sensors


NOISY = """<Scene Format="iw.v1" Name="noisy" Map="door" Seed="1">
  <Cast Name="chair" Robot="rear-wheel" Mind="{mind}" Place="start"><Option Name="MotorNoise" Value="0.05"/></Cast>
  <Cast Name="table" Robot="table" Mind="{other}" Place="{place}"/>
  <End><Reach Agent="chair" Place="goal" Within="0.3"/></End>
  <Experiment Subject="chair"><Uniform Place="start" Name="Y" Low="-0.2" High="0.2"/></Experiment>
</Scene>"""


def noisy(folder: Path, mind: str = "drive", other: str = "table", place: str = "back-start") -> SceneWorld:
    file = folder / "noisy.xml"
    file.write_text(NOISY.format(mind=mind, other=other, place=place))
    return SceneWorld(load_task(file))


def test_seed_moves_places_and_noise_and_gives_the_same_run_again(tmp_path: Path) -> None:
    world = noisy(tmp_path)
    runs = []
    for seed in ("1", "2", "1"):
        world.reset(seed)
        start = world.learners["chair"].position
        for _ in range(20):
            world.advance({"chair": POWERS})
        runs.append((start, world.pose("chair")))
    assert runs[0] == runs[2]
    assert runs[0][0].y != runs[1][0].y
    assert runs[0][1][0] != runs[1][1][0]


def test_mind_of_a_file_beside_the_scene_plays_and_may_leave(tmp_path: Path) -> None:
    (tmp_path / "goes.py").write_text(
        "from intellwheels_agents import Actions\n"
        "class Mind:\n    def __init__(self, context): pass\n"
        "    def decide(self, measures): return Actions(leave=measures.tick == 3)\n"
    )
    world = noisy(tmp_path, other="goes.py")
    world.reset("1")
    for _ in range(6):
        world.advance({"chair": POWERS})
    assert world.state.names == ("chair",)


def test_mind_that_fails_is_named(tmp_path: Path) -> None:
    (tmp_path / "fails.py").write_text(
        "class Mind:\n    def __init__(self, context): pass\n    def decide(self, measures): return 1 / 0\n"
    )
    world = noisy(tmp_path, other="fails.py")
    world.reset("1")
    with pytest.raises(ZeroDivisionError) as raised:
        world.advance({"chair": POWERS})
    assert raised.value.__notes__ == ["raised by the mind of agent 'table'"]


def test_world_that_has_not_begun_says_so() -> None:
    with pytest.raises(RuntimeError, match=r"expected reset\(\)"):
        SceneWorld(load_task("door")).pose("chair")
