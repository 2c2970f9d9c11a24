"""The page of one browser: its panels, camera, selection and controls. Freed when the browser leaves."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_schemas.agent_colours import natural_key
from intellwheels_schemas.messages import OperatorSay, Result
from intellwheels_viewer.cameras import Camera, Mode
from intellwheels_viewer.control_tabs import ControlCalls, ControlTabs
from intellwheels_viewer.drag_move import DragMove
from intellwheels_viewer.drawings import real_badge, wedges
from intellwheels_viewer.drawings.notice import Notice
from intellwheels_viewer.drawings.selection import Selection
from intellwheels_viewer.goal_click import GoalClick
from intellwheels_viewer.head_turn import eye_of
from intellwheels_viewer.held_ghost import HeldGhost
from intellwheels_viewer.inside_view import InsideView
from intellwheels_viewer.layer_visibility import LayerVisibility
from intellwheels_viewer.limited_worlds import LimitedWorlds, Worlds
from intellwheels_viewer.page_rights import EVERYTHING, PageRights
from intellwheels_viewer.page_title import PageTitle
from intellwheels_viewer.panels.agents import AgentsPanel
from intellwheels_viewer.panels.callbacks import assign, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import ClockPanel
from intellwheels_viewer.panels.connection import ConnectionPanel, empty_scene_text
from intellwheels_viewer.panels.events import EventsPanel
from intellwheels_viewer.panels.layers_panel import LayersPanel
from intellwheels_viewer.panels.page_keys import PageKeys
from intellwheels_viewer.panels.plan_panel import PlanPanel
from intellwheels_viewer.panels.playback import PlaybackPanel
from intellwheels_viewer.panels.selected import SelectedPanel
from intellwheels_viewer.placing_click import PlacingClick
from intellwheels_viewer.pointer_hover import PointerHover
from intellwheels_viewer.run_control import RunControl, step_hint
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import Driving, RequestQueue
from intellwheels_viewer.undo import UndoStack

if TYPE_CHECKING:
    from intellwheels_viewer.palette import Colours

WIDTH: Final = 288
"""Width of a panel in pixels: in a window of 1280 two panels leave more than half for the scene."""
MODES: Final[dict[str, Mode]] = {
    "Free (O)": "free", "Plan (P)": "plan", "Follow selected (F)": "follow", "From the chair (H)": "first",
}  # fmt: skip
"""Camera modes by label; a label ends with its key."""
LABELS: Final = {mode: label for label, mode in MODES.items()}
REFUSED: Final = 8.0
"""Seconds for which a refusal is shown; the same refusal is not shown again meanwhile."""


class Page:
    """The page of a connected browser.

    Args:
        client: The browser.
        network: Takes requests and inputs.
        colours: The colour of each agent.
        visit: How the browser has come, and what its user may do.
        dark: Whether the building has the colours of the dark theme.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        network: Worlds,
        colours: Colours,
        visit: PageRights = EVERYTHING,
        *,
        dark: bool = False,
    ) -> None:
        self._client, self._colours = client, colours
        self._visit = self._rights = visit
        self._network = network = LimitedWorlds(network, lambda: self._visit)
        # First, because it waits for the browser.
        self._layers = LayerVisibility(client, dark=dark)
        self._requests = RequestQueue(network, self._refused)
        self._driving = Driving(network, self._requests)
        self._snapshot = Snapshot()
        self.selected: str | None = None
        self._refusal, self._refused_at = ("", ""), -REFUSED
        self._undo = UndoStack()
        self._run_control = RunControl(self._requests)
        self._held_ghost = HeldGhost(client.scene)
        self._placing_click = PlacingClick(client, self._requests, self._held_ghost, lambda: self._snapshot, self._undo)
        self._drag_move = DragMove(client, self._requests, self._held_ghost, colours, self._undo)
        self._goal_click = GoalClick(client, self._driving, self._notify)
        self._ring = Selection(client.scene, "/selected")
        self._inside = InsideView(client.scene, dark=dark)
        self._notice = Notice(client.scene)
        self._framed = -1
        self.camera = Camera(client)
        self._build(client.gui)

    def close(self) -> None:
        """The browser has left."""
        self._driving.close()
        self._requests.close()

    def join(self, seconds: float) -> None:
        """Wait after `close` until all requests were sent, at most this many seconds."""
        self._requests.join(seconds)

    @property
    def view_state(self) -> tuple[object, ...]:
        """The choices of this browser that affect the drawing; a change redraws even a paused run."""
        return self.selected, self.camera.mode, self._layers.layers, self.camera.turning

    # ------------------------------------------------------------ output, on the drawing thread

    def draw(self, snapshot: Snapshot) -> None:
        """Update what moves in this browser: the selection ring and a following camera. Once per drawn tick."""
        self._snapshot = snapshot
        selected = self.selected
        entity = None if selected is None else snapshot.entity(selected)
        body = None if selected is None else snapshot.bodies.get(selected)
        with self._client.atomic():
            layers, is_inside = self._layers.layers, self.camera.mode == "first"
            # The own ring would be in the way of who looks down.
            self._ring.show(None if body is None or is_inside else body.robot, entity)
            if body is not None:
                self.camera.eye = eye_of(body.robot, layers.eye_height, layers.field_of_view)
            if entity is not None:
                self.camera.follow(entity)
            if snapshot.floor is not None and snapshot.revision != self._framed:
                self._framed = snapshot.revision
                self.camera.frame(snapshot.floor)
            self._layers.draw_walls(snapshot, inside=is_inside)
            self._inside.show(
                snapshot,
                entity if is_inside else None,
                self.camera.eye,
                full_walls=layers.full_walls,
                labels=layers.labels,
            )

    def panels(self, snapshot: Snapshot) -> None:
        """Update the panels. Four or five times a second."""
        self._snapshot = snapshot
        self._driving.tick()
        self._undo.enter(snapshot.run)
        self._run_control.start_waiting(snapshot)
        rights = snapshot.rights
        self._rights = self._visit if rights is None else self._visit.limited_by(rights)
        choices = self._choices()
        with self._client.atomic():
            self._connection.show(snapshot, choices)
            self._notice.show(empty_scene_text(snapshot, choices))
            self._clock.show(snapshot, choices)
            self._playback.show(snapshot, choices)
            self._agents.show(snapshot, choices)
            self._selected.show(snapshot, choices)
            self._events.show(snapshot)
            self._plan.show(snapshot, choices, visible=self._layers.layers.plan)
            self._controls.show(snapshot, choices)
            self._title.show(snapshot)
            assign(self._views, LABELS[self.camera.mode])

    def _choices(self) -> Choices:
        return Choices(
            selected=self.selected,
            looks={entity.name: self._colours.look(entity.name) for entity in self._snapshot.entities},
            rights=self._rights,
            driven=self._driving.driven,
            placing=self._placing_click.label,
            can_undo=bool(self._undo),
            quiet=self._network.quiet,
        )

    # ------------------------------------------------------------ elements

    def _build(self, gui: viser.GuiApi) -> None:
        run = self._run_control
        side = gui.add_panel()
        side.dock_left()
        side.set_width(WIDTH)
        with side.add_tab("Run"):
            self._title = PageTitle(gui)
            self._connection = ConnectionPanel(gui, on_world=self._network.choose)
            self._clock = ClockPanel(
                gui, on_pause=run.pause, on_resume=run.resume, on_step=run.step, on_reset=run.reset, on_speed=run.speed
            )
            self._playback = PlaybackPanel(
                gui,
                on_seek=run.seek,
                on_pause=run.pause,
                on_resume=lambda: run.play(self._snapshot),
                on_speed=run.speed,
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
        with tabs.add_tab("Layers"):
            self._layers_panel = LayersPanel(
                gui,
                self._layers.layers,
                self._layers.choose,
                legend=f'<div style="padding:4px 10px">{wedges.legend()}{real_badge.legend()}</div>',
            )
        self._controls = ControlTabs(
            gui,
            tabs,
            ControlCalls(
                stick=self._stick,
                say=self._say,
                aim=self._aim,
                choose=self._choose,
                turn=self._placing_click.turn,
                turn_selected=lambda degrees: self._drag_move.turn(self._snapshot, self.selected, degrees),
                remove=lambda: self._drag_move.remove(self.selected),
                undo=self._undo_newest,
            ),
        )
        self._keys = PageKeys(gui)
        self._hover = PointerHover(gui, self._placing_click.hover)
        self._commands(gui)

    def _commands(self, gui: viser.GuiApi) -> None:
        """Add keys to the command palette. Keys that move viser's own camera are not used."""

        def add(label: str, key: str, call: Callable[[], None]) -> None:
            command = gui.add_command(label, hotkey=key)  # type: ignore[arg-type]

            @command.on_trigger
            async def _(_: object) -> None:
                call()

        add("Pause, resume or run again", "space", self._toggle)
        add("Step one tick", "N", self._step)
        add("Stop placing", "escape", lambda: self._choose(None))
        add("Undo the last move", "Z", self._undo_newest)
        for label, mode in MODES.items():
            add(f"Camera: {label[:-4].lower()}", label[-2], self._looker(mode))
        for digit in range(1, 10):
            add(f"Select agent {digit}", str(digit), self._selector(digit - 1))

    def _looker(self, mode: Mode) -> Callable[[], None]:
        return lambda: self.look(mode)

    def _selector(self, index: int) -> Callable[[], None]:
        def call() -> None:
            names = sorted((entity.name for entity in self._snapshot.entities), key=natural_key)
            if index < len(names):
                self.select(names[index])

        return call

    # ------------------------------------------------------------ selection, in viser's loop: nothing here blocks

    def select(self, name: str | None) -> None:
        """Select a body, or none with None."""
        if name != self.selected:
            self._driving.stick(None, 0.0, 0.0)
        self.selected = name
        if name is None and self.camera.mode in ("follow", "first"):
            self.look("free")
        elif self.camera.mode in ("follow", "first"):
            self.look(self.camera.mode)

    def look(self, mode: Mode) -> None:
        """Change the camera mode."""
        entity = None if self.selected is None else self._snapshot.entity(self.selected)
        if entity is None and mode in ("follow", "first"):
            self._notify("Nothing is selected", "Click a chair first.")
            return
        self.camera.choose(mode, entity)

    def _toggle(self) -> None:
        if self._snapshot.is_over:
            self._notify("Run again", "A new run of the scene begins.")
        self._run_control.toggle(self._snapshot)

    def _step(self) -> None:
        why = step_hint(self._snapshot)
        if why is None:
            self._run_control.step(1)
        else:
            self._notify("Not stepped", why)

    # ------------------------------------------------------------ driving

    def _stick(self, forward: float, turn: float, _: int) -> None:
        self._driving.stick(self.selected, forward, turn)

    def _say(self, text: str, to: str | None) -> None:
        def said(_: Result) -> None:
            self._network.note_speech(text, to)

        self._requests.ask("Not sent", "say", OperatorSay(to=to, text=text), said)

    def _aim(self) -> None:
        """Take the next click on the floor as the goal."""
        self._choose(None)
        self._goal_click.begin(self._snapshot, self.selected)

    # ------------------------------------------------------------ placing and moving

    def _choose(self, label: str | None) -> None:
        self._goal_click.end()
        self._placing_click.choose(label)
        self._hover.listen(self._placing_click.label is not None)

    def _undo_newest(self) -> None:
        undo = self._undo.pop()
        if undo is None:
            self._notify("Nothing to undo", "Moves, turns and placed bodies of this run can be undone.")
        else:
            self._requests.ask("Not undone", *undo)

    def drag(self, name: str, event: viser.SceneNodeDragEvent[viser.SceneNodeHandle]) -> None:
        """Take one event of a drag that began on a body."""
        self._drag_move.drag(self._snapshot, name, event)

    # ------------------------------------------------------------ notices

    def _refused(self, what: str, why: str) -> None:
        # While a stick is held, the request is repeated every second. The same notice would fill the page.
        if (what, why) == self._refusal and time.monotonic() < self._refused_at + REFUSED:
            return
        self._refusal, self._refused_at = (what, why), time.monotonic()
        self._client.add_notification(what, why, color="red", auto_close_seconds=REFUSED)

    def _notify(self, title: str, text: str) -> None:
        self._client.add_notification(title, text, auto_close_seconds=5.0)
