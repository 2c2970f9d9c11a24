"""The bodies: one batch for each look and material, so that a thousand chairs need as many nodes as ten.

The nodes of a look are made once. A body in contact has a red footprint, a stale one is faded, the selected one has a
ring.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

import numpy as np
import viser

from intellwheels_schemas.messages import Body, Entity
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import footprint_outlines
from intellwheels_viewer.drawings.body_documents import BodyDocument, BodyDocuments
from intellwheels_viewer.drawings.body_look import CROWD, BodyLook
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.drawings.glb import painted
from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.looks import model_of
from intellwheels_viewer.drawings.selection import Selection
from intellwheels_viewer.drawings.solids import Array, box, join
from intellwheels_viewer.drawings.walking_legs import WalkingLegs

FADED: Final = 0.35
"""Opacity of stale bodies."""

_TINT: Final = 0.25
_STRIPE: Final[palette.RGB] = (255, 255, 255)

Click: TypeAlias = viser.SceneNodePointerEvent[Any]
Drag: TypeAlias = viser.SceneNodeDragEvent[Any]
OnPick: TypeAlias = Callable[[str, Click], None]
OnDrag: TypeAlias = Callable[[str, Drag], None]


@dataclass(frozen=True)
class PoseArrays:
    """Poses and colours of N bodies: positions (N, 3) in metres, headings (N,), colours (N, 3) in sRGB bytes."""

    names: tuple[str, ...]
    positions: Array
    headings: Array
    colours: Array


def pose_arrays(entities: Sequence[Entity], colour: Callable[[str], palette.RGB]) -> PoseArrays:
    """Return the poses and colours of bodies as arrays, in their order."""
    return PoseArrays(
        names=tuple(entity.name for entity in entities),
        positions=np.array([(entity.x, entity.y, 0.0) for entity in entities], np.float32).reshape(-1, 3),
        headings=np.array([entity.heading for entity in entities], np.float32),
        colours=np.array([colour(entity.name) for entity in entities], np.uint8).reshape(-1, 3).astype(np.float32),
    )


def grouped(documents: Mapping[str, BodyDocument], entities: Sequence[Entity]) -> dict[int, list[Entity]]:
    """Return bodies by look, in the order of the state. Bodies whose document has not arrived are left out."""
    groups: dict[int, list[Entity]] = {}
    for entity in entities:
        document = documents.get(entity.name)
        if document is not None:
            groups.setdefault(document.look, []).append(entity)
    return groups


def tints(
    documents: Mapping[str, BodyDocument], entities: Sequence[Entity], colour: Callable[[str], palette.RGB]
) -> tuple[PoseArrays, Array]:
    """Return the poses and sizes (N, 3) of tinted footprints: those of mobile bodies and of bodies in contact."""
    shown = [e for e in entities if e.name in documents and (documents[e.name].is_mobile or e.contact)]
    hulls = [documents[entity.name].hull for entity in shown]
    placed = pose_arrays(shown, colour)
    middles = np.array([hull.middle for hull in hulls], np.float32).reshape(-1, 2)
    cos, sin = np.cos(placed.headings), np.sin(placed.headings)
    placed.positions[:, 0] += cos * middles[:, 0] - sin * middles[:, 1]
    placed.positions[:, 1] += sin * middles[:, 0] + cos * middles[:, 1]
    sizes = np.array([(hull.length, hull.width, 1.0) for hull in hulls], np.float32).reshape(-1, 3)
    return placed, sizes


class _Look:
    """The nodes of one look."""

    def __init__(
        self,
        scene: viser.SceneApi,
        name: str,
        model: BodyLook,
        document: BodyDocument,
        made: Callable[[InstanceBatch], None],
    ) -> None:
        self.model = model
        self._scene, self._name, self._made = scene, name, made
        self._fresh = self._batches()
        self._stale: list[InstanceBatch] = []
        self._legs = None if model.leg is None else WalkingLegs(scene, f"{name}/legs", model.leg, made)
        dashed = document.is_mobile and document.robot.type != "real"
        self._outline = InstanceBatch(
            scene, f"{name}/outline", footprint_outlines.outline(document.hull, dashed=dashed)
        )

    def show(self, fresh: PoseArrays, stale: PoseArrays, lines: PoseArrays, walkers: Sequence[Entity]) -> None:
        _assign(self._fresh, fresh)
        if stale.names and not self._stale:
            self._stale = self._faded()
        _assign(self._stale, stale)
        if self._legs is not None:
            self._legs.show(walkers)
        self._outline.show(lines.positions, quaternions(lines.headings), lines.colours, names=lines.names)

    def _batches(self) -> list[InstanceBatch]:
        """Return a node in the colour of each agent, and one of all other colours."""
        paint, trim = self.model.paint, painted(self.model.trim)
        return [
            InstanceBatch(self._scene, f"{self._name}/{part}", shape, shadow=True, made=self._made)
            for part, shape in (("paint", paint), ("trim", trim))
        ]

    def _faded(self) -> list[InstanceBatch]:
        """Return the same for stale bodies. Only simple solids can be faded, so all is in the colour of the agent."""
        paint, trim = self.model.paint, join(self.model.trim.values())
        return [
            InstanceBatch(self._scene, f"{self._name}/stale/{part}", shape, opacity=FADED, made=self._made)
            for part, shape in (("paint", paint), ("trim", trim))
        ]


def _assign(batches: Sequence[InstanceBatch], placed: PoseArrays) -> None:
    turns = quaternions(placed.headings)
    for batch in batches:
        batch.show(placed.positions, turns, placed.colours, names=placed.names)


class Bodies:
    """All bodies in a scene.

    Args:
        scene: The shared scene, or that of one browser.
        name: The parent of the nodes.
        cut: The height at which doors are cut, as walls are; None for full height.

    Attributes:
        documents: What was last shown of each body, by agent.
    """

    def __init__(self, scene: viser.SceneApi, *, name: str = "/bodies", cut: float | None = HALF_HEIGHT) -> None:
        self._scene, self._name, self._cut = scene, name, cut
        self._documents = BodyDocuments()
        self.documents: Mapping[str, BodyDocument] = {}
        self._looks: dict[int, _Look] = {}
        self._clickable: list[InstanceBatch] = []
        self._picks: list[OnPick] = []
        self._drags: list[tuple[OnDrag, Literal["shift"] | None]] = []
        self._tint = InstanceBatch(scene, f"{name}/tint", footprint_outlines.tint(), opacity=_TINT, made=self._listen)
        self._contact = InstanceBatch(scene, f"{name}/contact", footprint_outlines.tint(), opacity=0.7)
        self._stripes = InstanceBatch(scene, f"{name}/stripes", box(-0.025, 0.025, -0.5, 0.5, 0.0, 0.006))
        self._ring = Selection(scene, f"{name}/selection")

    @property
    def names(self) -> dict[str, tuple[str, ...]]:
        """The agents of the instances of each node, by node name, in the order of viser's `instance_index`."""
        return {batch.handle.name: batch.names for batch in self._clickable if batch.handle is not None}

    def on_pick(self, callback: OnPick) -> None:
        """Call back with an agent's name and viser's event when a body is clicked.

        The callback runs in viser's event loop, which keeps the order of events, so it must return at once.
        """
        self._picks.append(callback)
        for batch in self._clickable:
            self._listen_pick(batch, callback)

    def on_drag(self, callback: OnDrag, *, modifier: Literal["shift"] | None = None) -> None:
        """Call back with an agent's name and viser's event when a body is dragged with the left button.

        All events of a drag name the body on which it began. The callback runs in viser's event loop, as in `on_pick`.
        """
        self._drags.append((callback, modifier))
        for batch in self._clickable:
            self._listen_drag(batch, callback, modifier)

    def show(
        self,
        bodies: Mapping[str, Body],
        entities: Sequence[Entity],
        colours: palette.Colours,
        stale: Collection[str] = frozenset(),
        selected: str | None = None,
    ) -> None:
        """Show the bodies at their poses.

        Args:
            bodies: Documents by agent.
            entities: States.
            colours: The colours; new agents get theirs here.
            stale: Agents that are drawn faded.
            selected: The agent with the ring; None if each browser has its own `Selection`.
        """
        colours.see(bodies)
        crowd = len(entities) > CROWD
        documents = self.documents = self._documents.of(bodies, crowd=crowd)
        groups = grouped(documents, entities)
        for number, group in groups.items():
            look = self._look(number, documents[group[0].name], crowd=crowd)
            look.show(*self._poses(group, documents, colours, stale), group)
        nobody = pose_arrays((), colours.rgb)
        for number in self._looks.keys() - groups.keys():
            self._looks[number].show(nobody, nobody, nobody, ())
        self._show_floor(documents, entities, colours)
        self._show_stripes(groups, colours)
        chosen = next((entity for entity in entities if entity.name == selected), None)
        body = None if chosen is None else bodies.get(chosen.name)
        self._ring.show(None if body is None else body.robot, chosen)

    def _look(self, number: int, document: BodyDocument, *, crowd: bool) -> _Look:
        look = self._looks.get(number)
        if look is None:
            model = model_of(document.robot, crowd=crowd, cut=self._cut, occupied=document.occupied)
            name = f"{self._name}/{len(self._looks)}-{document.robot.kind}"
            look = self._looks[number] = _Look(self._scene, name, model, document, self._listen)
        return look

    @staticmethod
    def _poses(
        group: Sequence[Entity], documents: Mapping[str, BodyDocument], colours: palette.Colours, stale: Collection[str]
    ) -> tuple[PoseArrays, PoseArrays, PoseArrays]:
        """Return the opaque bodies, the faded ones, and the outlines of mobile bodies and of bodies in contact."""
        fresh = [entity for entity in group if entity.name not in stale]
        faded = [entity for entity in group if entity.name in stale]
        lined = [entity for entity in group if entity.contact or documents[entity.name].is_mobile]
        touching = {entity.name for entity in lined if entity.contact}
        return (
            pose_arrays(fresh, colours.rgb),
            pose_arrays(faded, colours.rgb),
            pose_arrays(lined, lambda name: palette.CONTACT if name in touching else colours.rgb(name)),
        )

    def _show_floor(
        self, documents: Mapping[str, BodyDocument], entities: Sequence[Entity], colours: palette.Colours
    ) -> None:
        placed, sizes = tints(documents, [entity for entity in entities if not entity.contact], colours.rgb)
        self._tint.show(
            placed.positions, quaternions(placed.headings), placed.colours, scales=sizes, names=placed.names
        )
        placed, sizes = tints(documents, [entity for entity in entities if entity.contact], lambda _: palette.CONTACT)
        self._contact.show(placed.positions, quaternions(placed.headings), placed.colours, scales=sizes)

    def _show_stripes(self, groups: Mapping[int, Sequence[Entity]], colours: palette.Colours) -> None:
        rows = [
            (entity.x, entity.y, entity.heading, x - 0.1 * stripe, z, across)
            for number, group in groups.items()
            for x, z, across in [self._looks[number].model.stripe]
            for entity in group
            for stripe in range(colours.mark(entity.name))
        ]
        x, y, heading, back, z, across = np.array(rows, np.float64).reshape(-1, 6).T
        places = np.column_stack([x + back * np.cos(heading), y + back * np.sin(heading), z])
        scales = np.column_stack([np.ones(len(rows)), across, np.ones(len(rows))])
        self._stripes.show(places, quaternions(heading), np.tile(_STRIPE, (len(rows), 1)), scales=scales)

    def _listen(self, batch: InstanceBatch) -> None:
        self._clickable.append(batch)
        for callback in self._picks:
            self._listen_pick(batch, callback)
        for drag, modifier in self._drags:
            self._listen_drag(batch, drag, modifier)

    @staticmethod
    def _listen_pick(batch: InstanceBatch, callback: OnPick) -> None:
        assert batch.handle is not None  # noqa: S101  # called when it is made

        @batch.handle.on_click
        async def _(event: Click) -> None:
            name = _named(batch.names, event.instance_index)
            if name is not None:
                callback(name, event)

    @staticmethod
    def _listen_drag(batch: InstanceBatch, callback: OnDrag, modifier: Literal["shift"] | None) -> None:
        assert batch.handle is not None  # noqa: S101  # called when it is made
        held: dict[int, str] = {}

        @batch.handle.on_drag("left", modifier=modifier)
        async def _(event: Drag) -> None:
            if event.phase == "start":
                name = _named(batch.names, event.instance_index)
                if name is not None:
                    held[event.client_id] = name
            else:
                name = held.get(event.client_id)
            if event.phase == "end":
                held.pop(event.client_id, None)
            if name is not None:
                callback(name, event)


def _named(names: Sequence[str], index: int | None) -> str | None:
    """Return the agent of an instance; None if it left before the event arrived."""
    return names[index] if index is not None and 0 <= index < len(names) else None
