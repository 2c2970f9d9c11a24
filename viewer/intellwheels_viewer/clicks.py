"""Clicks on the floor in one browser, while something waits for them. Otherwise a click only moves the camera."""

from __future__ import annotations

from collections.abc import Callable

import viser

from intellwheels_viewer.cameras import on_floor


class FloorClicks:
    """Reports clicks on the floor while it is switched on.

    Args:
        scene: The scene of the browser.
        call: Called with the point, in metres, in the order of the clicks. A click beside the floor is ignored.
    """

    def __init__(self, scene: viser.SceneApi, call: Callable[[float, float], None]) -> None:
        self._scene, self._call = scene, call
        self._heard: Callable[[viser.SceneClickEvent], None] | None = None

    def listen(self, on: bool) -> None:
        """Switch it on or off."""
        if on and self._heard is None:

            async def click(event: viser.SceneClickEvent) -> None:
                at = on_floor(event.ray_origin, event.ray_direction)
                if at is not None:
                    self._call(*at)

            self._heard = self._scene.on_click()(click)  # type: ignore[arg-type]
        elif not on and self._heard is not None:
            self._scene.remove_click_callback(self._heard)
            self._heard = None
