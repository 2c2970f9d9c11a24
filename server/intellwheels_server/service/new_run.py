"""What follows when the world became another run: reset, load, restore. Whoever looks is told all of it at once."""

from __future__ import annotations

import numpy as np

from intellwheels_server.service import outbound
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world import State
from intellwheels_server.world.inputs import Inputs
from intellwheels_server.world.kernels import rows


def begin_new_run(service: ServiceState, before: State, now: float) -> None:
    """Record the change of runs, forget what belonged to the one before, and publish everything.

    Args:
        desk: Its state is that of the new run already.
        before: The last state of the run before.
        now: The caller's seconds.
    """
    if service.record is not None:
        service.record(before.tick, Inputs(changes=tuple(service.changes)), service.digest(), stepped=False)
    service.changes.clear()
    service.close_steps("failed", "the run was begun anew")
    service.latch.clear()
    names, rested = service.state.names, np.nonzero(service.state.flags[rows.RESTED])[0].tolist()
    service.barrier.begin_new_run(names[i] for i in rested)
    service.held, service.open = True, False
    service.metronome.late = 0
    service.tachometer.stop()
    outbound.publish_map(service)
    for name in names:
        service.out.body(name, outbound.body_of(service, name))
    outbound.publish(service, now)
    service.out.note(f"began run={service.state.run} before={before.run} seed={service.state.setup.seed!r}")
