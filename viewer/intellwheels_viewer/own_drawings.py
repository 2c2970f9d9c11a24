"""What one browser draws in its own scene: labels and a sun for its camera, and the wedges of its selection."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_viewer.drawings.label_layout import Picture
from intellwheels_viewer.drawings.labels import Labels, tags, unlabelled
from intellwheels_viewer.drawings.sun import OwnSun
from intellwheels_viewer.drawings.wedges import Wedges

if TYPE_CHECKING:
    from intellwheels_schemas.messages import Entity
    from intellwheels_viewer.panels.layers_panel import Layers
    from intellwheels_viewer.snapshot import Snapshot

LABELS: Final = "/own/labels"
WEDGES: Final = "/own/wedges"
FEW: Final = 12
"""Up to this many bodies labels follow them closely."""
OFTEN: Final = 0.1
SELDOM: Final = 0.2
"""Seconds of wall time between two updates of the labels of few and of more bodies."""


class OwnDrawings:
    """The drawings of one browser.

    Args:
        client: The browser.
        picture: Returns its camera, or None while it is not known.
        now: A monotonic clock, in seconds.

    Attributes:
        seen: The bodies in sight, if the browser looks from a chair; None if it looks from elsewhere.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        picture: Callable[[], Picture | None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        scene = client.scene
        self._frames = {name: scene.add_frame(name, show_axes=False) for name in (LABELS, WEDGES)}
        self._labels, self._wedges = Labels(scene, LABELS), Wedges(scene, WEDGES)
        self._sun = OwnSun(scene)
        self._picture, self._now = picture, now
        self._next = -SELDOM
        self.seen: list[Entity] | None = None
        self._was_inside = False

    def draw(self, snapshot: Snapshot, selected: str | None, layers: Layers) -> None:
        """Draw the wedges of the selection and, if it is time, the labels. Once per drawn tick."""
        hides = self.seen is not None and not layers.senses
        own = layers.wedges and not layers.all_wedges and selected is not None and not hides
        self._frames[WEDGES].visible = own
        if own:
            self._wedges.show(snapshot.bodies, snapshot.entities, snapshot.measures, {selected or ""})
        self.label(snapshot, selected, layers)

    def label(self, snapshot: Snapshot, selected: str | None, layers: Layers) -> None:
        """Draw the sun, and the labels if it is time: with the bodies, and while the camera of a paused run moves."""
        self._frames[LABELS].visible = layers.labels
        picture, now = self._picture(), self._now()
        self._sun.show(picture)
        if self._was_inside != (self.seen is not None):
            self._was_inside, self._next = self.seen is not None, now  # names behind walls go at once
        if not layers.labels or now < self._next or picture is None:
            return
        entities = snapshot.entities if self.seen is None else self.seen
        self._next = now + (OFTEN if len(entities) <= FEW else SELDOM)
        wanted = () if selected is None else (selected,)
        wishes = tags(snapshot.bodies, entities, snapshot.utterances, snapshot.time, wanted)
        self._labels.show(wishes, picture, unlabelled(snapshot.bodies, entities, wishes))
