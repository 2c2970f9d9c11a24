from __future__ import annotations

from intellwheels_server.world import Setup, begin, digest
from intellwheels_server.world.empty_world import empty_world
from intellwheels_server.world.kernels.rows import FLAG_ROWS, NUMBER_ROWS
from intellwheels_server.world.map_geometry import walls_of
from tests.server.worlds import RUN, box_wall, floor_of


def test_empty_world_is_at_tick_0_and_has_arrays_without_columns() -> None:
    setup = Setup(floor=floor_of([box_wall(1.0, 1.0, 2.0, 2.0)]))
    state = empty_world(setup, RUN, walls_of(setup.floor))
    assert (state.run, state.tick, state.names, state.event_count) == (RUN, 0, (), 0)
    assert (state.numbers.shape, state.flags.shape) == ((NUMBER_ROWS, 0), (FLAG_ROWS, 0))
    assert digest(state) == digest(begin(setup, RUN))
