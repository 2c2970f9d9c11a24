from __future__ import annotations

import dataclasses

import msgspec
import numpy as np
import pytest

from intellwheels_experiments.batch.run_measures import measure_run
from intellwheels_experiments.batch.trace_reader import Trace
from intellwheels_maps import floor, scene
from intellwheels_schemas.messages import Event
from tests.experiments.runs import straight

SCENE, FLOOR = scene("table1"), floor("corridor15m")


def test_run_that_stops_short_has_not_reached_its_place() -> None:
    numbers, series = measure_run(straight(ticks=100), SCENE, FLOOR, "chair", real=False)
    assert (numbers.reached, numbers.success, numbers.spl) == (False, False, 0.0)
    assert numbers.path == pytest.approx(2.5)
    assert numbers.time == pytest.approx(5.0)
    assert len(series.true) == len(series.times) == len(series.clearance) == 101


def test_clearance_is_the_smallest_of_the_run() -> None:
    numbers, _ = measure_run(straight(ticks=40, aside=0.5), SCENE, FLOOR, "chair", real=False)
    assert numbers.clearance == pytest.approx(1.2 - 0.5 - 0.33)


@pytest.mark.parametrize("real", [True, False])
def test_contact_is_physical_for_a_real_chair_and_virtual_otherwise(real: bool) -> None:
    numbers, series = measure_run(straight(hits=(5, 60)), SCENE, FLOOR, "chair", real=real)
    assert (numbers.contacts_physical, numbers.contacts_virtual) == ((2, 0) if real else (0, 2))
    assert numbers.collided
    assert [one.tick for one in series.contacts] == [5, 60]


def mirror(other: str) -> Trace:
    """Return a mirror that shows the chair half a metre aside, where it touches something."""
    trace = straight(aside=0.5, hits=(7,))
    moment = trace.moments[7]
    event = msgspec.structs.replace(moment.event[0], other=other)
    moments = list(trace.moments)
    moments[7] = msgspec.structs.replace(moment, event=(event,))
    return dataclasses.replace(trace, moments=moments)


def test_mirrored_pose_of_a_chair_in_a_laboratory_is_its_reported_pose() -> None:
    numbers, series = measure_run(straight(), SCENE, FLOOR, "chair", real=True, mirror=mirror("wall"))
    assert series.reported is not None
    assert series.reported[-2] - series.true[-2] == pytest.approx(np.array([0.0, 0.5, 0.0]))
    # The laboratory ends before the mirror shows its last tick.
    assert (series.reported[-1] == series.reported[-2]).all()
    assert numbers.odometry_error == pytest.approx(0.5)
    assert (numbers.contacts_physical, numbers.contacts_virtual, numbers.collided) == (0, 1, False)


def test_contact_with_a_body_of_the_simulation_alone_is_a_collision() -> None:
    numbers, _ = measure_run(straight(), SCENE, FLOOR, "chair", real=True, mirror=mirror("table"))
    assert (numbers.contacts_virtual, numbers.collided) == (1, True)


def test_effort_is_measured_in_manual_runs_only() -> None:
    trace = straight(ticks=20)
    assert measure_run(trace, SCENE, FLOOR, "chair", real=False)[0].effort is None
    manual = [
        msgspec.structs.replace(one, body={"chair": msgspec.structs.replace(one.body["chair"], mode="manual")})
        for one in trace.moments
    ]
    numbers, _ = measure_run(dataclasses.replace(trace, moments=manual), SCENE, FLOOR, "chair", real=False)
    assert numbers.effort == pytest.approx(0.5)
    assert (numbers.agreement, numbers.interventions) == (1.0, 0)


def test_taking_the_chair_is_an_intervention() -> None:
    trace = straight(ticks=20)
    taken = Event(run=trace.heading.run, tick=3, number=0, code="taken", agent="chair")
    moments = list(trace.moments)
    moments[3] = msgspec.structs.replace(moments[3], event=(taken,))
    numbers, _ = measure_run(dataclasses.replace(trace, moments=moments), SCENE, FLOOR, "chair", real=False)
    assert numbers.interventions == 1
