"""Clicks on the floor are heard while they are wanted."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from intellwheels_viewer.clicks import FloorClicks

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


class Scene:
    """Keeps who listens."""

    def __init__(self) -> None:
        self.listeners: list[Any] = []

    def on_click(self) -> Any:
        def keep(call: Any) -> Any:
            self.listeners.append(call)
            return call

        return keep

    def remove_click_callback(self, call: Any) -> None:
        self.listeners.remove(call)


def click(scene: Scene, *direction: float) -> None:
    event = SimpleNamespace(ray_origin=(1.0, 2.0, 4.0), ray_direction=direction)
    for call in scene.listeners:
        asyncio.run(call(event))


def test_the_floor_is_hit_where_the_ray_meets_it_and_only_while_somebody_listens() -> None:
    scene, hits = Scene(), list[tuple[float, float]]()
    clicks = FloorClicks(scene, lambda x, y: hits.append((x, y)))  # type: ignore[arg-type]
    click(scene, 0.0, 0.0, -1.0)
    assert hits == []
    clicks.listen(True)
    clicks.listen(True)
    click(scene, 0.0, 0.0, -1.0)
    click(scene, 0.0, 0.0, 1.0)  # into the sky
    assert hits == [(1.0, 2.0)]
    clicks.listen(False)
    clicks.listen(False)
    click(scene, 0.0, 0.0, -1.0)
    assert hits == [(1.0, 2.0)]
