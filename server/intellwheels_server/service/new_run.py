"""Begins a new run in the service, after a reset, load or restore of the world."""

from __future__ import annotations

import numpy as np

from intellwheels_server.service import outbound
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world import State
from intellwheels_server.world.kernels import rows


def begin_new_run(service: ServiceState, before: State, now: float) -> None:
    """Record the change of runs, drop what belonged to the earlier run, and publish everything.

    Args:
        service: Its state is that of the new run already.
        before: The last state of the earlier run.
        now: The current time, s.
    """
    service.run.record_changes(before.tick)
    service.answer_steps("failed", "a new run began")
    service.latch.clear()
    service.command_ages.clear()
    service.travelled.clear()
    state = service.run.state
    service.pacing.begin_new_run([state.names[i] for i in np.nonzero(state.flags[rows.RESTED])[0].tolist()])
    outbound.publish_map(service.run, service.publisher)
    for name in state.names:
        outbound.publish_body(service, name)
    outbound.publish(service, now)
    service.publisher.outlet.log_line(f"began run={state.run} before={before.run} seed={state.setup.seed!r}")
