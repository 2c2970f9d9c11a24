from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import viser

from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.solids import box
from tests.viewer.drawings.cast import node

CUBE = box(0.0, 1.0, 0.0, 1.0, 0.0, 1.0)


def test_headings_become_turns_about_the_upright_axis() -> None:
    turns = quaternions([0.0, math.pi])
    assert turns == pytest.approx(np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]), abs=1e-7)
    assert quaternions([]).shape == (0, 4)


def show(batch: InstanceBatch, count: int) -> None:
    batch.show(np.zeros((count, 3)), quaternions([0.0] * count), [(0, 188, 255)] * count, names=["a"] * count)


def test_a_node_is_made_when_there_is_something_to_show_and_then_kept(scene: viser.SceneApi) -> None:
    made: list[InstanceBatch] = []
    batch = InstanceBatch(scene, "/b", CUBE, made=made.append)
    show(batch, 0)
    assert node(scene, "/b") is None
    show(batch, 2)
    handle = batch.handle
    assert handle is node(scene, "/b")
    show(batch, 0)
    assert handle is not None
    assert not handle.visible
    show(batch, 3)
    assert batch.handle is handle
    assert node(scene, "/b").visible
    assert node(scene, "/b").batched_positions.shape == (3, 3)
    assert batch.names == ("a", "a", "a")
    assert made == [batch]


def test_colours_are_given_as_light(scene: viser.SceneApi) -> None:
    batch = InstanceBatch(scene, "/b", CUBE)
    show(batch, 1)
    handle: Any = batch.handle
    assert handle.batched_colors.tolist() == [[0, 128, 255]]


def test_a_batch_of_none_names_nobody_and_is_hidden(scene: viser.SceneApi) -> None:
    batch = InstanceBatch(scene, "/b", CUBE)
    show(batch, 1)
    show(batch, 0)
    assert batch.names == ()
    assert batch.handle is not None
    assert not batch.handle.visible


def test_only_what_changed_is_assigned(scene: viser.SceneApi) -> None:
    assigned: list[str] = []

    class Handle:
        def __setattr__(self, name: str, value: object) -> None:
            assigned.append(name)

    batch = InstanceBatch(scene, "/b", CUBE)
    show(batch, 2)
    batch.handle = Handle()  # type: ignore[assignment]
    show(batch, 2)
    assigned.clear()
    show(batch, 2)
    assert assigned == []
    batch.show(np.ones((2, 3)), quaternions([0.0] * 2), [(0, 188, 255)] * 2, names=["a"] * 2)
    assert assigned == ["batched_positions"]
    show(batch, 3)
    assert assigned[1:] == ["batched_positions", "batched_wxyzs", "batched_colors"]
    show(batch, 0)
    assert assigned[4:] == ["visible"]
