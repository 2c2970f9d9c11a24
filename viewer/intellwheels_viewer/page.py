"""One browser: its panels, its camera, what it selected, and its hand on the run. Freed when it goes."""

from __future__ import annotations

import dataclasses
import math
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, Literal, Protocol

import msgspec
import viser

from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    Delete,
    Goal,
    OperatorSay,
    Pause,
    Position,
    Reset,
    Resume,
    Seek,
    Spawn,
    Speed,
    Step,
    Teleport,
    UserInput,
)
from intellwheels_viewer.cameras import Camera, Mode, on_floor, ray
from intellwheels_viewer.drawings import wedges
from intellwheels_viewer.drawings.ghosts import Ghost, Ghosts
from intellwheels_viewer.drawings.layers import HALF_HEIGHT
from intellwheels_viewer.drawings.selection import Selection
from intellwheels_viewer.drawings.walls import Walls
from intellwheels_viewer.hover import Hover
from intellwheels_viewer.panels import layers as layers_panel
from intellwheels_viewer.panels.agents import AgentsPanel
from intellwheels_viewer.panels.callbacks import assign, clicked, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import ClockPanel
from intellwheels_viewer.panels.connection import ConnectionPanel
from intellwheels_viewer.panels.drive import DrivePanel
from intellwheels_viewer.panels.events import EventsPanel
from intellwheels_viewer.panels.layers import Layers, LayersPanel
from intellwheels_viewer.panels.place import PALETTE, PlacePanel
from intellwheels_viewer.panels.plan import PlanPanel
from intellwheels_viewer.panels.playback import PlaybackPanel
from intellwheels_viewer.panels.selected import SelectedPanel
from intellwheels_viewer.seen import Seen
from intellwheels_viewer.stage import LAYERS
from intellwheels_viewer.steering import Driving, Simulator, Wishes

if TYPE_CHECKING:
    from intellwheels_viewer.palette import Colours

WIDTH: Final = 288
"""Pixels of a panel: at 1280 two of them leave the scene more than half."""
LAYERS_KEY: Final = "intellwheels.layers"
MODES: Final[dict[str, Mode]] = {
    "Free (O)": "free", "Plan (P)": "plan", "Follow selected (F)": "follow", "From the chair (H)": "first",
}  # fmt: skip
"""The ways to look, with their keys."""
LABELS: Final = {mode: label for label, mode in MODES.items()}
GHOST_COLOUR: Final = (90, 100, 115)
REFUSED: Final = 20.0
"""Seconds for which the page says why the last wish was refused."""
NUDGE: Final = 0.05
"""Metres: a body pulled less far was clicked."""


class Worlds(Simulator, Protocol):
    """The link, as a page knows it."""

    @property
    def quiet(self) -> float:
        """Seconds since the last clock."""

    def choose(self, world: str) -> None:
        """Watch another world."""


class Page:
    """A browser that is connected.

    Args:
        client: Whose it is.
        network: Where wishes go.
        colours: The colour of each agent.
    """

    def __init__(self, client: viser.ClientHandle, network: Worlds, colours: Colours) -> None:
        self._client, self._network, self._colours = client, network, colours
        # Asked for before anything is made: it waits for the page.
        self._layers = layers_panel.from_json(_kept(client))
        self._wishes = Wishes(network, self._refused)
        self._driving = Driving(network, self._wishes)
        self._seen = Seen()
        self.selected: str | None = None
        self._refusal, self._refused_at = "", 0.0
        self._placing: str | None = None
        self._aiming = False
        self._turn = 0.0
        # The page's messages and the answers to its wishes move it, in two threads.
        self._ghost_lock = threading.Lock()
        self._ghosts = Ghosts(client.scene)
        self._ghost: Ghost | None = None
        self._pulled: tuple[str, float, float] | None = None
        self._ring = Selection(client.scene, "/selected")
        self._walls: Walls | None = None
        self._walls_of = -1
        self._hidden: dict[str, viser.FrameHandle] = {}
        self._framed = -1
        self._clicks: Callable[[viser.SceneClickEvent], None] | None = None
        self.camera = Camera(client)
        self._build(client.gui)
        self._hide()

    def close(self) -> None:
        """The browser is gone."""
        self._driving.close()
        self._wishes.close()

    def join(self, seconds: float) -> None:
        """Wait until all it asked for is said after `close`, or so long."""
        self._wishes.join(seconds)

    @property
    def outlook(self) -> tuple[object, ...]:
        """What of this browser decides what is drawn; another one is drawn even while the run stands still."""
        return self.selected, self.camera.mode, self._layers

    # ------------------------------------------------------------ shown, by the drawing thread

    def draw(self, seen: Seen) -> None:
        """Go on with what moves: the ring, and the camera that follows. Once per drawn tick."""
        self._seen = seen
        selected = self.selected
        entity = None if selected is None else seen.entity(selected)
        body = None if selected is None else seen.bodies.get(selected)
        with self._client.atomic():
            self._ring.show(None if body is None else body.robot, entity)
            if entity is not None:
                self.camera.follow(entity)
            if seen.floor is not None and seen.revision != self._framed:
                self._framed = seen.revision
                self.camera.frame(seen.floor)
            self._draw_walls(seen)

    def panels(self, seen: Seen) -> None:
        """Show what is read: figures, plan, plots. Four or five times a second."""
        self._seen = seen
        self._driving.tick()
        choices = self._choices()
        with self._client.atomic():
            self._connection.show(seen, choices)
            self._clock.show(seen, choices)
            self._playback.show(seen, choices)
            self._agents.show(seen, choices)
            self._selected.show(seen, choices)
            self._events.show(seen)
            self._plan.show(seen, choices, visible=self._layers.plan)
            self._drive.show(seen, choices)
            self._place.show(seen, choices)
            assign(self._views, LABELS[self.camera.mode])
            self._goal.visible = self._takes_goals()

    def _choices(self) -> Choices:
        colours = {entity.name: self._colours.rgb(entity.name) for entity in self._seen.entities}
        return Choices(
            selected=self.selected,
            colours=colours,
            placing=self._placing,
            refusal=self._refusal if time.monotonic() < self._refused_at + REFUSED else "",
            quiet=self._network.quiet,
        )

    def _draw_walls(self, seen: Seen) -> None:
        whole = self._layers.full_walls or self.camera.mode == "first"
        wanted = seen.revision if whole else -1
        if seen.floor is None or wanted == self._walls_of:
            return
        self._walls_of = wanted
        if self._walls is None:
            self._walls = Walls(self._client.scene)
        # Its nodes hide those of all browsers, so they are kept and drawn low again.
        self._walls.show(seen.floor, None if whole else HALF_HEIGHT)

    # ------------------------------------------------------------ made

    def _build(self, gui: viser.GuiApi) -> None:
        ask = self._ask
        side = gui.add_panel()
        side.dock_left()
        side.set_width(WIDTH)
        with side.add_tab("Run"):
            self._connection = ConnectionPanel(gui, on_world=self._network.choose)
            self._clock = ClockPanel(
                gui,
                on_pause=ask("Not paused", "pause", Pause),
                on_resume=ask("Not resumed", "resume", Resume),
                on_step=lambda count: self._wishes.ask("Not stepped", "step", Step(count=count)),
                on_reset=ask("Not begun anew", "reset", Reset),
                on_speed=lambda factor: self._wishes.ask("Speed not changed", "speed", Speed(factor=factor)),
            )
            self._playback = PlaybackPanel(
                gui,
                on_seek=lambda tick: self._wishes.ask("Not sought", "seek", Seek(tick=tick)),
                on_pause=ask("Not paused", "pause", Pause),
                on_resume=ask("Not resumed", "resume", Resume),
                on_speed=lambda factor: self._wishes.ask("Speed not changed", "speed", Speed(factor=factor)),
            )
            self._views: viser.GuiDropdownHandle[str] = gui.add_dropdown("Camera", tuple(MODES))
            updated(self._views, lambda word: self.look(MODES.get(word, "free")))
            self._plan = PlanPanel(gui, on_select=self.select)
            self._events = EventsPanel(gui)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(WIDTH)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Agents"):
            self._agents = AgentsPanel(gui, on_select=self.select)
            self._selected = SelectedPanel(gui)
        with tabs.add_tab("Drive"):
            self._drive = DrivePanel(gui, on_stick=self._stick, on_say=self._say)
            self._goal = gui.add_button("Set a goal", icon=viser.Icon.FLAG, color="gray")
            clicked(self._goal, self._aim)
        with tabs.add_tab("Place"):
            self._place = PlacePanel(
                gui,
                on_choose=self._choose,
                on_turn=self._turned,
                on_turn_selected=self._turn_selected,
                on_remove=self._remove,
            )
        with tabs.add_tab("Layers"):
            self._layers_panel = LayersPanel(
                gui, self._layers, self._relayer, legend=f'<div style="padding:4px 10px">{wedges.legend()}</div>'
            )
        self._hover = Hover(gui, self._hovered)
        self._commands(gui)

    def _commands(self, gui: viser.GuiApi) -> None:
        """Keys and palette. None of the keys that move viser's own camera."""

        def add(label: str, key: str, call: Callable[[], None]) -> None:
            command = gui.add_command(label, hotkey=key)  # type: ignore[arg-type]

            @command.on_trigger
            async def _(_: object) -> None:
                call()

        add("Pause or resume", "space", self._pause_or_resume)
        add("Step one tick", "N", self._step_one)
        for label, mode in MODES.items():
            add(f"Camera: {label[:-4].lower()}", label[-2], self._looker(mode))
        for digit in range(1, 10):
            add(f"Select agent {digit}", str(digit), self._selector(digit - 1))

    def _looker(self, mode: Mode) -> Callable[[], None]:
        return lambda: self.look(mode)

    def _selector(self, index: int) -> Callable[[], None]:
        def call() -> None:
            names = sorted(entity.name for entity in self._seen.entities)
            if index < len(names):
                self.select(names[index])

        return call

    def _ask(
        self, what: str, verb: Literal["pause", "resume", "reset"], wish: type[Pause | Resume | Reset]
    ) -> Callable[[], None]:
        return lambda: self._wishes.ask(what, verb, wish())

    # ------------------------------------------------------------ chosen, in viser's loop: nothing here waits

    def select(self, name: str | None) -> None:
        """Select a body, or none."""
        if name != self.selected:
            self._driving.stick(None, 0.0, 0.0)
        self.selected = name
        if name is None and self.camera.mode in ("follow", "first"):
            self.look("free")
        elif self.camera.mode in ("follow", "first"):
            self.look(self.camera.mode)

    def look(self, mode: Mode) -> None:
        """Look in another way."""
        entity = None if self.selected is None else self._seen.entity(self.selected)
        if entity is None and mode in ("follow", "first"):
            self._notify("Nothing selected", "Click a chair first.")
            return
        self.camera.choose(mode, entity)

    def _pause_or_resume(self) -> None:
        clock = self._seen.clock
        if clock is not None and clock.state == "paused":
            self._wishes.ask("Not resumed", "resume", Resume())
        else:
            self._wishes.ask("Not paused", "pause", Pause())

    def _step_one(self) -> None:
        self._wishes.ask("Not stepped", "step", Step(count=1))

    def _relayer(self, layers: Layers) -> None:
        self._layers = layers
        self._client.local_storage.set_item(LAYERS_KEY, layers.to_json())
        self._hide()

    def _hide(self) -> None:
        """Hide layers by nodes of this browser that stand before those of all."""
        for layer, node in LAYERS.items():
            shown = bool(getattr(self._layers, layer))
            if not shown and layer not in self._hidden:
                self._hidden[layer] = self._client.scene.add_frame(node, show_axes=False, visible=False)
            elif layer in self._hidden:
                self._hidden[layer].visible = shown

    # ------------------------------------------------------------ driven

    def _stick(self, forward: float, turn: float, _: int) -> None:
        self._driving.stick(self.selected, forward, turn)

    def _say(self, text: str, to: str | None) -> None:
        self._wishes.ask("Not said", "say", OperatorSay(to=to, text=text))

    def _aim(self) -> None:
        """The next click on the floor is a goal."""
        body = None if self.selected is None else self._seen.bodies.get(self.selected)
        if body is None:
            self._notify("No goal set", "Nothing selected: click a chair first.")
        elif not self._takes_goals():
            self._notify("No goal set", f"The mind of {self.selected} takes no goals.")
        else:
            self._choose(None)
            self._aiming = True
            self._listen(True)
            self._notify("Click the floor", f"Where shall {self.selected} go?")

    def _takes_goals(self) -> bool:
        body = None if self.selected is None else self._seen.bodies.get(self.selected)
        return body is not None and "goal" in body.robot.user_input

    # ------------------------------------------------------------ placed

    def _choose(self, label: str | None) -> None:
        self._placing = label if label in PALETTE else None
        self._aiming = False
        self._listen(self._placing is not None)
        self._hover.listen(self._placing is not None)
        if self._placing is None:
            self._show_ghost(None)
            return
        look_at = self._client.camera.look_at
        self._preview(float(look_at[0]), float(look_at[1]))

    def _preview(self, x: float, y: float) -> None:
        """Show what would be placed where it would stand."""
        placing = self._placing
        if placing is not None:
            self._show_ghost(Ghost(robot(PALETTE[placing]), x, y, self._turn, GHOST_COLOUR))

    def _hovered(self, right: float, up: float) -> None:
        """The pointer is over the scene: what would be placed stands under it, as a ghost."""
        at = on_floor(*ray(self._client.camera, right, up))
        if at is not None:
            self._preview(*at)

    def _turned(self, degrees: float) -> None:
        if not math.isfinite(degrees):
            return  # a page's values are a stranger's
        self._turn = math.radians(degrees)
        ghost = self._ghost
        if ghost is not None and self._placing is not None:
            self._show_ghost(dataclasses.replace(ghost, heading=self._turn))

    def _listen(self, on: bool) -> None:
        """Hear clicks on the floor, or no longer."""
        scene = self._client.scene
        if on and self._clicks is None:

            async def click(event: viser.SceneClickEvent) -> None:
                self._clicked(on_floor(event.ray_origin, event.ray_direction))

            self._clicks = scene.on_click()(click)  # type: ignore[arg-type]
        elif not on and self._clicks is not None:
            scene.remove_click_callback(self._clicks)
            self._clicks = None

    def _clicked(self, at: tuple[float, float] | None) -> None:
        if at is None:
            return
        if self._aiming and self.selected is not None:
            self._network.put_user(self.selected, UserInput(goal=Goal(x=at[0], y=at[1])))
            self._aiming = False
            self._listen(False)
        elif self._placing is not None:
            made = robot(PALETTE[self._placing])
            self._preview(*at)
            wish = Spawn(
                robot=msgspec.structs.replace(made, name=self._free_name(PALETTE[self._placing]), format=None),
                position=_position(at[0], at[1], self._turn),
            )
            self._wishes.ask("Not placed", "spawn", wish, lambda _: self._show_ghost(None), lambda _: self._redden())

    def _free_name(self, stem: str) -> str:
        taken = {entity.name for entity in self._seen.entities}
        return next(name for number in range(1, 10_000) if (name := f"{stem}{number}") not in taken)

    def _turn_selected(self, degrees: float) -> None:
        entity = None if self.selected is None else self._seen.entity(self.selected)
        if entity is not None:
            position = _position(entity.x, entity.y, entity.heading + math.radians(degrees))
            self._wishes.ask("Not turned", "teleport", Teleport(agent=entity.name, position=position))

    def _remove(self) -> None:
        if self.selected is not None:
            self._wishes.ask("Not removed", "delete", Delete(agent=self.selected))

    # ------------------------------------------------------------ dragged

    def drag(self, name: str, event: viser.SceneNodeDragEvent[viser.SceneNodeHandle]) -> None:
        """Take one event of a drag that began on a body: a ghost moves, and at the end the body is asked to."""
        at = self._under(event.end_position)
        entity, body = self._seen.entity(name), self._seen.bodies.get(name)
        if event.phase == "start" or self._pulled is None or self._pulled[0] != name:
            start = self._under(event.start_position)
            if start is None or entity is None:
                return
            self._pulled = (name, entity.x - start[0], entity.y - start[1])
        if entity is None or body is None or at is None:
            self._pulled = None
            self._show_ghost(None)
            return
        x, y = at[0] + self._pulled[1], at[1] + self._pulled[2]
        far = math.hypot(x - entity.x, y - entity.y) > NUDGE
        if far:
            self._show_ghost(Ghost(body.robot, x, y, entity.heading, self._colours.rgb(name)))
        if event.phase == "end":
            self._pulled = None
            if far:
                wish = Teleport(agent=name, position=_position(x, y, entity.heading))
                self._wishes.ask(
                    "Not placed", "teleport", wish, lambda _: self._show_ghost(None), lambda _: self._show_ghost(None)
                )
            else:
                self._show_ghost(None)

    def _under(self, point: tuple[float, float, float]) -> tuple[float, float] | None:
        """Return the floor under the pointer: viser tells where it is on a plane that faces the camera."""
        eye = self._client.camera.position
        return on_floor(eye, (point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]))

    def _show_ghost(self, ghost: Ghost | None) -> None:
        with self._ghost_lock:
            self._ghost = ghost
            self._ghosts.show({} if ghost is None else {"hand": ghost})

    def _redden(self) -> None:
        ghost = self._ghost
        if ghost is not None:
            self._show_ghost(dataclasses.replace(ghost, refused=True))

    # ------------------------------------------------------------ said

    def _refused(self, what: str, why: str) -> None:
        self._refusal, self._refused_at = f"{what}: {why}", time.monotonic()
        self._client.add_notification(what, why, color="red", auto_close_seconds=8.0)

    def _notify(self, title: str, text: str) -> None:
        self._client.add_notification(title, text, auto_close_seconds=5.0)


def _position(x: float, y: float, heading: float) -> Position:
    turned = math.remainder(heading, math.tau)
    return Position(x=x, y=y, heading=math.pi if turned <= -math.pi else turned)


def _kept(client: viser.ClientHandle) -> str | None:
    try:
        return client.local_storage.get_item(LAYERS_KEY, timeout=2.0)
    except (TimeoutError, RuntimeError):
        return None  # it does not answer, may not keep anything, or has left
