"""What follows when the world became another run: reset, load, restore. Whoever looks is told all of it at once."""

from __future__ import annotations

import numpy as np

from intellwheels_server import publication
from intellwheels_server.desk import Desk
from intellwheels_server.inputs import Inputs
from intellwheels_server.kernels.rows import RESTED
from intellwheels_server.world import State


def begin_anew(desk: Desk, before: State, now: float) -> None:
    """Record the change of runs, forget what belonged to the one before, and publish everything.

    Args:
        desk: Its state is that of the new run already.
        before: The last state of the run before.
        now: The caller's seconds.
    """
    if desk.record is not None:
        desk.record(before.tick, Inputs(changes=tuple(desk.changes)), desk.digest(), stepped=False)
    desk.changes.clear()
    desk.close_steps("failed", "the run was begun anew")
    desk.tray.clear()
    names, rested = desk.state.names, np.nonzero(desk.state.flags[RESTED])[0].tolist()
    desk.barrier.begin_anew(names[i] for i in rested)
    desk.held, desk.open = True, False
    desk.metronome.late = 0
    desk.tachometer.stop()
    publication.publish_map(desk)
    for name in names:
        desk.out.body(name, publication.body_of(desk, name))
    publication.publish(desk, now)
    desk.out.note(f"began run={desk.state.run} before={before.run} seed={desk.state.setup.seed!r}")
