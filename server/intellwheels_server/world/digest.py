"""The hash of a state, by which runs are compared, and the hash of a map."""

from __future__ import annotations

import hashlib

import msgspec
import numpy as np

from intellwheels_schemas.messages import Map
from intellwheels_server.world.state import State


def digest(state: State) -> str:
    """Return the hash of a state: 16 hex digits of BLAKE2b-64 over its tick, bodies and sensor memory.

    The input is little-endian float64: first the tick, then the numbers and flags of each body in the order of names,
    then the memory of sensors (`SensorPlan.memory`). -0.0 counts as 0.0. The name of the run is not included, so equal
    runs have equal hashes.

    Raises:
        FloatingPointError: A number is not finite, which is a bug.
    """
    block = np.empty((state.numbers.shape[1], state.numbers.shape[0] + state.flags.shape[0]), dtype="<f8")
    block[:, : state.numbers.shape[0]] = state.numbers.T
    block[:, state.numbers.shape[0] :] = state.flags.T
    block += 0.0
    if not np.isfinite(block).all():
        raise FloatingPointError(f"state of tick {state.tick}: expected finite numbers, got {block}")
    hashed = hashlib.blake2b(np.float64(state.tick).tobytes(), digest_size=8)
    hashed.update(block.tobytes())
    if len(state.body_set.plan.memory):
        remembered = (state.samples[state.body_set.plan.memory] + 0.0).astype("<f8")
        if not np.isfinite(remembered).all():
            raise FloatingPointError(f"sensors at tick {state.tick}: expected finite numbers, got {remembered}")
        hashed.update(remembered.tobytes())
    return hashed.hexdigest()


def map_hash(floor: Map) -> str:
    """Return 16 hex digits of BLAKE2b-64 over the JSON of a map."""
    return hashlib.blake2b(msgspec.json.encode(floor), digest_size=8).hexdigest()
