from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Change, DeleteBody, Inputs, Join, Note
from intellwheels_schemas.messages import Actions
from intellwheels_server.log.branch import read_branch
from intellwheels_server.log.input_log import Line, Log, LogError
from intellwheels_server.world import Setup, advance, begin, digest

RUN = "0123456789abcdef"


def written(path: Path, *changes: Change, at: int = 3) -> list[str]:
    """Write a log of six ticks with changes at one of them; return the hash of each."""
    setup = Setup(floor=floor("room"), seed="7")
    log, state, hashes = Log(path, setup, RUN), begin(setup, RUN), []
    for tick in range(6):
        made: tuple[Change, ...] = (Join(agent="one", robot=robot("rear-wheel")),) if tick == 0 else ()
        inputs = Inputs(
            changes=made + (changes if tick == at else ()),
            actions={"one": Actions(left_motor=0.5, right_motor=0.1 * tick)},
        )
        state, _ = advance(state, inputs)
        hashes.append(digest(state))
        log.write(Line(tick=tick, inputs=inputs, hash=hashes[-1]), 0.0)
    log.close()
    return hashes


def test_inputs_come_from_the_parent_until_the_branch(tmp_path: Path) -> None:
    hashes = written(tmp_path / "log")
    branch = read_branch(tmp_path / "log", 4)
    assert branch.agents == ("one",)
    told = branch.inputs(0)
    assert told is not None
    assert (told.changes, told.actions["one"].left_motor) == ((), 0.5)
    assert branch.inputs(4) is None
    assert branch.differs(2, hashes[2]) is None
    assert branch.differs(2, "0" * 16) == f"tick 3: expected the parent's hash {hashes[2]}, got {'0' * 16}"
    assert branch.setup({"strict": True}).seed == "7"


def test_branch_ignores_a_pause_in_the_parent(tmp_path: Path) -> None:
    written(tmp_path / "log", Note(code="paused"), Note(code="resumed"))
    assert read_branch(tmp_path / "log", 5).at == 5


def test_branch_after_a_change_by_an_operator_is_refused(tmp_path: Path) -> None:
    written(tmp_path / "log", DeleteBody(agent="one"))
    assert read_branch(tmp_path / "log", 3).at == 3
    with pytest.raises(LogError, match="expected only joins at tick 0 before a branch, got DeleteBody"):
        read_branch(tmp_path / "log", 4)


def test_tick_beyond_the_end_is_refused(tmp_path: Path) -> None:
    written(tmp_path / "log")
    with pytest.raises(LogError, match=r"expected a tick in \[0, 6\] to branch at, got 7"):
        read_branch(tmp_path / "log", 7)
