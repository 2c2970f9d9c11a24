"""A map of several hospitals side by side: what happens in one has no influence on another."""

from __future__ import annotations

from intellwheels_maps.hospital import LENGTH
from intellwheels_schemas.file_records import Depart, Inputs
from intellwheels_server.world import State, advance, apply, digest
from intellwheels_server.world.kernels.rows import TOUCHING, X
from intellwheels_server.world.sensors.proximity import FEWEST_SHARED
from tests.bench.tick import APART, commands, hospital_world


def test_bodies_of_one_hospital_move_to_the_bit_as_if_the_others_were_empty() -> None:
    everybody = hospital_world(300, plans=3)
    west = LENGTH + 0.5 * APART
    there = [name for name, x in zip(everybody.names, everybody.numbers[X].tolist(), strict=True) if x < west]
    assert 70 < len(there) < 150
    alone, _ = apply(everybody, [Depart(agent=name) for name in everybody.names if name not in there])
    powers = commands(everybody)
    touched = 0.0
    for tick in range(60):
        everybody, _ = advance(everybody, Inputs(actions=powers[tick % 20]))
        alone, _ = advance(alone, Inputs(actions={name: powers[tick % 20][name] for name in there}))
        touched = max(touched, float(alone.numbers[TOUCHING].max()))
    columns = [everybody.body_set.index[name] for name in there]
    assert touched == 1.0
    assert everybody.numbers[:, columns].tolist() == alone.numbers.tolist()
    assert [samples_of(everybody, name) for name in there] == [samples_of(alone, name) for name in there]


def test_two_threads_give_the_same_world_to_the_bit_as_one() -> None:
    one = two = hospital_world(FEWEST_SHARED + 40)
    powers = commands(one)
    for tick in range(5):
        one, _ = advance(one, Inputs(actions=powers[tick]))
        two, _ = advance(two, Inputs(actions=powers[tick]), threads=2)
    assert digest(one) == digest(two)
    assert one.samples.tobytes() == two.samples.tobytes()


def samples_of(state: State, name: str) -> list[float]:
    fitting = state.body_set.plan.fittings[state.body_set.index[name]]
    return list(state.samples[fitting.begin : fitting.end].tolist())
