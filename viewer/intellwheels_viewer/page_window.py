"""What one page does with its window: panels beside the scene or below it, the theme, and what panels leave free."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import viser

from intellwheels_viewer.panels.page_shell import NARROW, PHONE
from intellwheels_viewer.stage import NIGHT, SKY, background

if TYPE_CHECKING:
    from intellwheels_viewer.cameras import Camera
    from intellwheels_viewer.panels.page_shell import Window

WIDTH: Final = 288
"""Width of a panel in pixels: in a window of 1280 two panels leave more than half for the scene."""
SLIM: Final = 240
"""The same in a window that is less than `NARROW` wide, such as a phone held sideways."""
BAR: Final = 56
"""Height of the bar of a narrow window in pixels."""
SHARE: Final = 0.38
"""Share of a narrow window's height that its panels have, below the scene (chosen)."""
THEME_KEY: Final = "intellwheels.theme"
SYSTEM: Final = "System"
THEMES: Final = (SYSTEM, "Light", "Dark")


class PageWindow:
    """The window of one browser.

    Args:
        client: The browser.
        camera: Its camera.
        side: The panel beside the main one.
        dark: Whether the viewer was told to use the dark theme; a browser's own choice goes before it.
        theme: What the browser stored as its choice, if anything.
    """

    def __init__(
        self, client: viser.ClientHandle, camera: Camera, side: viser.PanelHandle, *, dark: bool, theme: str | None
    ) -> None:
        self._client, self._camera, self._side = client, camera, side
        self.theme = theme if theme in THEMES else "Dark" if dark else SYSTEM
        self._system_dark = False
        self._dark: bool | None = None
        self._below: tuple[float, float] | None = None
        self._beside = WIDTH
        self._show_theme()

    @property
    def is_dark(self) -> bool:
        """Whether the page is dark now."""
        return bool(self._dark)

    def choose(self, theme: str) -> None:
        """Use one of `THEMES` and remember it in this browser."""
        self.theme = theme
        self._client.local_storage.set_item(THEME_KEY, theme)
        self._show_theme()

    def changed(self, window: Window) -> None:
        """Take what the page says about its window."""
        self._system_dark = window.dark
        self._show_theme()
        self._place(window)
        self._camera.leave_free(window.covered, window.aspect)

    def _place(self, window: Window) -> None:
        main, side = self._client.gui.main_panel, self._side
        if window.width >= min(NARROW, window.height):
            width = WIDTH if window.width >= NARROW else SLIM
            if self._beside != width:
                self._beside, self._below = width, None
                side.dock_left()
                side.set_width(width)
                main.dock_right()
                main.set_width(width)
        elif window.width >= PHONE and self._below != (window.width, window.height):
            # A phone has viser's sheet, which needs no place.
            self._beside, self._below = 0, (window.width, window.height)
            half, high = window.width / 2, SHARE * window.height
            top = window.height - BAR - high
            side.float(x=0, y=top, width=half, height=high)
            main.float(x=half, y=top, width=half, height=high)

    def _show_theme(self) -> None:
        dark = self._system_dark if self.theme == SYSTEM else self.theme == "Dark"
        if dark == self._dark:
            return
        self._dark = dark
        gui, scene = self._client.gui, self._client.scene
        with self._client.atomic():
            gui.configure_theme(
                show_logo=False,
                show_share_button=False,
                dark_mode=dark,
                brand_color=(45, 135, 210) if dark else (0, 90, 158),
            )
            scene.set_background_image(background(NIGHT if dark else SKY), format="png")


def stored_theme(client: viser.ClientHandle) -> str | None:
    """Return what the browser stored as its theme; None if nothing, or if it does not answer or stores nothing."""
    try:
        return client.local_storage.get_item(THEME_KEY, timeout=2.0)
    except (TimeoutError, RuntimeError):
        return None
