"""Words in the middle of a scene in which there is nothing to see yet: an empty page says why it is empty."""

from __future__ import annotations

import viser


class Notice:
    """One label at the origin, where a view looks that no floor has framed. Its node is kept.

    Args:
        scene: A browser's own.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._label: viser.LabelHandle | None = None

    def show(self, text: str) -> None:
        """Show these words, lines apart by a line break; nothing for none."""
        label = self._label
        if label is None:
            if text:
                self._label = self._scene.add_label("/notice", text, anchor="center-center", depth_test=False)
            return
        label.visible = bool(text)
        if text and label.text != text:
            label.text = text
