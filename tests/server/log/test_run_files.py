"""Each run of a process that is reset stands alone: its log runs again by itself, its trace says what was true."""

from __future__ import annotations

from pathlib import Path

import msgspec

from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Inputs, Join, Restart
from intellwheels_schemas.messages import Actions, Event
from intellwheels_server.__main__ import main
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.log.run_files import LOG, TRACE, RunFiles
from intellwheels_server.world import Setup, State, advance, apply, begin, digest
from intellwheels_server.world.kernels import rows

FIRST, SECOND = "1" * 16, "2" * 16


class World:
    """A world that is stepped and reset as the service does it."""

    def __init__(self, folder: Path) -> None:
        self.state: State = begin(Setup(floor=floor("room"), seed="1"), FIRST)
        self.files = RunFiles(folder, "main", lambda: self.state)

    def step(self, inputs: Inputs) -> None:
        tick = self.state.tick
        self.state, outputs = advance(self.state, inputs)
        for event in outputs.events:
            self.files.add_event(event)
        self.files.record(tick, inputs, digest(self.state), stepped=True)

    def reset(self, seed: str) -> None:
        tick, restart = self.state.tick, Restart(run=SECOND, seed=seed)
        self.state, _ = apply(self.state, (restart,))
        self.files.record(tick, Inputs(changes=(restart,)), digest(self.state), stepped=False)


def played(folder: Path) -> World:
    world = World(folder)
    noisy = msgspec.structs.replace(robot("rear-wheel"), motor_noise=0.1)
    go = {"one": Actions(left_motor=0.8, right_motor=0.7), "two": Actions(left_motor=0.1, right_motor=0.2)}
    world.step(Inputs(changes=(Join(agent="one", robot=noisy), Join(agent="two", robot=noisy)), actions=go))
    for _ in range(4):
        world.step(Inputs(actions=go))
    world.reset("another")
    for _ in range(6):
        world.step(Inputs(actions=go))
    world.files.close()
    return world


def test_log_of_each_run_runs_again_by_itself(tmp_path: Path) -> None:
    world = played(tmp_path)
    first, second = resimulate(tmp_path / FIRST / LOG), resimulate(tmp_path / SECOND / LOG)
    assert (first.differs, first.ticks) == (None, 5)
    assert (second.differs, second.ticks, second.hash) == (None, 6, digest(world.state))


def test_trace_has_every_tick_and_is_not_rounded(tmp_path: Path) -> None:
    world = played(tmp_path)
    lines = [msgspec.json.decode(line) for line in (tmp_path / SECOND / TRACE).read_bytes().splitlines()]
    assert (lines[0]["Run"], lines[0]["Seed"], lines[0]["Floor"]) == (SECOND, "another", "room")
    assert [line["Tick"] for line in lines[1:]] == list(range(7))
    assert lines[-1]["Body"]["one"]["Pose"][0] == float(world.state.numbers[rows.X, 0])
    assert lines[-1]["Body"]["one"]["Wheels"][0] > 0


def test_trace_of_a_log_is_that_of_the_run(tmp_path: Path) -> None:
    played(tmp_path)
    again = tmp_path / "again.jsonl"
    assert main(["--resimulate", str(tmp_path / SECOND / LOG), "--trace", str(again)]) == 0
    assert again.read_bytes() == (tmp_path / SECOND / TRACE).read_bytes()


def test_event_is_in_the_line_of_its_tick(tmp_path: Path) -> None:
    world = World(tmp_path)
    world.step(Inputs(changes=(Join(agent="one", robot=robot("rear-wheel")),)))
    world.files.add_event(Event(run=FIRST, tick=2, number=9, code="contact", agent="one", other="wall"))
    world.step(Inputs())
    world.files.close()
    last = msgspec.json.decode((tmp_path / FIRST / TRACE).read_bytes().splitlines()[-1])
    assert [(event["Code"], event["Tick"]) for event in last["Event"]] == [("contact", 2)]


def test_run_without_a_step_leaves_no_files(tmp_path: Path) -> None:
    world = World(tmp_path)
    world.reset("2")
    world.files.close()
    assert list(tmp_path.iterdir()) == []
