import hashlib
import struct

import msgspec
import numpy as np

from intellwheels_schemas.messages import Compass, Odometry
from intellwheels_server.world import digest, map_hash
from intellwheels_server.world.kernels import rows
from tests.server.worlds import box_wall, cart, floor_of, run, world


def test_hash_is_blake2b_64_over_tick_numbers_and_flags_of_each_body_in_turn() -> None:
    state, _ = run(world({"b": cart(3.0), "a": cart()}), 2, {"a": (0.5, 0.1)})
    values = [2.0]
    for i in range(2):
        values += [*state.numbers[:, i], *state.flags[:, i].astype(float)]
    assert len(values) == 1 + 2 * (rows.NUMBER_ROWS + rows.FLAG_ROWS)
    packed = struct.pack(f"<{len(values)}d", *(value + 0.0 for value in values))
    assert digest(state) == hashlib.blake2b(packed, digest_size=8).hexdigest()


def test_what_sensors_remember_follows_the_bodies() -> None:
    state, _ = run(world({"a": cart(odometry=(Odometry(id="o"),)), "b": cart(3.0)}), 2, {"a": (0.5, 0.1)})
    remembered = state.samples[state.body_set.plan.memory]
    assert 0 < len(remembered) < len(state.samples)
    assert remembered.any()
    bare = digest(world({"a": cart(), "b": cart(3.0)}))
    assert bare == digest(world({"a": cart(compass=(Compass(id="c"),)), "b": cart(3.0)}))
    samples = state.samples.copy()
    samples[state.body_set.plan.memory[-1]] += 1.0
    assert digest(msgspec.structs.replace(state, samples=samples)) != digest(state)


def test_minus_zero_counts_as_zero() -> None:
    state = world({"a": cart()})
    before = digest(state)
    numbers = state.numbers.copy()
    numbers[rows.Y, 0] = -0.0
    assert np.signbit(numbers[rows.Y, 0])
    assert digest(msgspec.structs.replace(state, numbers=numbers)) == before


def test_maps_differ_in_their_hashes() -> None:
    assert map_hash(floor_of()) == map_hash(floor_of())
    assert map_hash(floor_of()) != map_hash(floor_of([box_wall(0.0, 0.0, 1.0, 1.0)]))
