"""A text in the middle of an empty scene that says why it is empty."""

from __future__ import annotations

import viser


class Notice:
    """A label at the origin, where the camera looks before there is a map. Its node is kept.

    Args:
        scene: The scene of a browser.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._label: viser.LabelHandle | None = None

    def show(self, text: str) -> None:
        """Show a text, which may have line breaks; an empty text hides the label."""
        label = self._label
        if label is None:
            if text:
                self._label = self._scene.add_label("/notice", text, anchor="center-center", depth_test=False)
            return
        label.visible = bool(text)
        if text and label.text != text:
            label.text = text
