"""In a process of its own, as a kernel that another test had compiled would hide what warming forgets."""

from __future__ import annotations

import subprocess
import sys

import numba
import pytest
from numba.core import event

from intellwheels_server.world.warmup import Announcer

pytestmark = pytest.mark.process

PROGRAM = """
import numba.core.event as event
from intellwheels_maps import floor, robot
from msgspec import structs
from intellwheels_schemas.messages import Actions, Lidar, Odometry, Position, Proximity
from intellwheels_schemas.file_records import Inputs, Join, TeleportBody
from intellwheels_server.world.warmup import warm
from intellwheels_server.world import Setup, advance, apply, begin, measures

warm()
with event.install_recorder("numba:compile") as compiled:
    state = begin(Setup(floor=floor("ward"), say_walls=True), run="0" * 16)
    kinds = ["rear-wheel", "mid-wheel", "table", "door"]
    joins = [Join(agent=f"a{k}", robot=robot(kind)) for k, kind in enumerate(kinds)]
    eye = Proximity(
        id="s", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, model="sonar", latency=1
    )
    lidar = Lidar(id="l", x=0.5, y=0.0, z=0.4, direction_deg=0.0, fov_deg=90.0, rays=91, max_range=4.0)
    equipped = structs.replace(robot("mid-wheel"), proximity=(eye,), lidar=(lidar,), odometry=(Odometry(id="o"),))
    joins.append(Join(agent="b", robot=equipped))
    state, _ = apply(state, joins)
    here = [name for name in state.names]
    if len(here) > 1:
        at = state.body_set.models[here[0]].start
        there = Position(x=at.x + 0.3, y=at.y, heading=1.0)
        state, _ = apply(state, [TeleportBody(agent=here[1], position=there, force=True)])
    for _ in range(100):
        drive = {name: Actions(left_motor=1.0, right_motor=0.8, say="hm") for name in here}
        state, outputs = advance(state, Inputs(actions=drive))
        for name in here:
            measures(state, name)
print(len(here), len(compiled.buffer))
"""


def test_nothing_is_compiled_after_the_warm_up() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    here, compiled = done.stdout.split()
    assert int(here) >= 2
    assert compiled == "0"


def test_compiling_is_announced_from_the_first_kernel_that_numba_compiles(capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever the cache holds: it may be of another Python, another numba or another processor."""
    announcer = Announcer()
    with event.install_listener("numba:compile", announcer):
        assert capsys.readouterr().err == ""
        assert numba.njit(lambda x: x + 1)(1) == 2
        assert numba.njit(lambda x: x + 2)(1) == 3
        announcer.end()
    began, *_, ended = capsys.readouterr().err.splitlines()
    assert began == "compiling kernels: only at the first start, about a minute"
    assert ended.startswith("compiled kernels seconds=")


def test_nothing_is_announced_where_nothing_is_compiled(capsys: pytest.CaptureFixture[str]) -> None:
    announcer = Announcer()
    with event.install_listener("numba:compile", announcer):
        announcer.end()
    assert capsys.readouterr().err == ""
