"""Clicks on the floor of one browser, heard only while somebody wants them: else a click turns the camera only."""

from __future__ import annotations

from collections.abc import Callable

import viser

from intellwheels_viewer.cameras import on_floor


class FloorClicks:
    """Whether one listener hears where the floor is clicked.

    Args:
        scene: The browser's own.
        call: Gets the point, in metres, in the order of the clicks. A click past the floor calls nobody.
    """

    def __init__(self, scene: viser.SceneApi, call: Callable[[float, float], None]) -> None:
        self._scene, self._call = scene, call
        self._heard: Callable[[viser.SceneClickEvent], None] | None = None

    def listen(self, on: bool) -> None:
        """Hear clicks, or no longer."""
        if on and self._heard is None:

            async def click(event: viser.SceneClickEvent) -> None:
                at = on_floor(event.ray_origin, event.ray_direction)
                if at is not None:
                    self._call(*at)

            self._heard = self._scene.on_click()(click)  # type: ignore[arg-type]
        elif not on and self._heard is not None:
            self._scene.remove_click_callback(self._heard)
            self._heard = None
