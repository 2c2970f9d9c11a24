from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Lidar, LidarReading, Measures, Sensors
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.lidar_points import Lidars, cloud, points
from tests.viewer.drawings.cast import RUN, body, entity, node

SENSOR = Lidar(id="scan", x=0.5, y=0.0, z=0.3, direction_deg=0.0, fov_deg=180.0, rays=3, max_range=10.0)
CHAIR = body("rear-wheel", lidar=(SENSOR,))
READING = LidarReading(id="scan", start_deg=-90.0, step_deg=90.0, ranges=(1.0, None, 23.456))
SEEN = {"a": Measures(run=RUN, tick=0, time=0.0, sensors=Sensors(lidar=(READING,)))}


def test_a_hit_is_where_the_ray_ended_and_a_ray_without_a_range_has_none() -> None:
    hits, ranges = points(SENSOR, READING, CHAIR, entity("a", 1.0, 2.0, math.pi / 2))
    assert hits == pytest.approx(np.array([[2.0, 2.5, 0.3], [-22.456, 2.5, 0.3]]), abs=1e-4)
    assert ranges == pytest.approx([1.0, 23.456])


def test_hits_have_the_colours_of_wedges() -> None:
    _, colours = cloud({"a": CHAIR}, [entity("a")], SEEN, {"a"})
    assert colours.tolist() == [list(palette.MIDDLE), list(palette.FAR)]


def test_only_the_asked_for_are_shown() -> None:
    hits, colours = cloud({"a": CHAIR}, [entity("a")], SEEN, set())
    assert hits.shape == colours.shape == (0, 3)


def test_points_are_sent_exactly_and_hidden_when_there_are_none(scene: viser.SceneApi) -> None:
    shown = Lidars(scene)
    shown.show({"a": CHAIR}, [entity("a")], SEEN, {"a"})
    handle = node(scene, "/lidar/points")
    assert handle.points.dtype == np.float32
    assert handle.points[1] == pytest.approx([0.5, 23.456, 0.3], abs=1e-5)
    shown.show({"a": CHAIR}, [entity("a")], {}, {"a"})
    assert not handle.visible
