"""The page of one browser: its panels, camera, selection and controls. Freed when the browser leaves."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
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
from intellwheels_viewer.own_drawings import OwnDrawings
from intellwheels_viewer.page_arrival import PageArrival
from intellwheels_viewer.page_link import PageLink, query_of
from intellwheels_viewer.page_notices import PageNotices
from intellwheels_viewer.page_recording import PageRecording
from intellwheels_viewer.page_rights import EVERYTHING, PageRights
from intellwheels_viewer.page_title import PageTitle
from intellwheels_viewer.page_window import THEMES, WIDTH, PageWindow, stored_theme
from intellwheels_viewer.panels.agents import AgentsPanel
from intellwheels_viewer.panels.callbacks import assign, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import ClockPanel
from intellwheels_viewer.panels.connection import ConnectionPanel, empty_scene_text
from intellwheels_viewer.panels.events import EventsPanel
from intellwheels_viewer.panels.layers_panel import LayersPanel
from intellwheels_viewer.panels.legend import legend_html
from intellwheels_viewer.panels.page_keys import PageKeys
from intellwheels_viewer.panels.page_shell import PageShell, Window, tools_html
from intellwheels_viewer.panels.plan_panel import PlanPanel
from intellwheels_viewer.panels.playback import PlaybackPanel
from intellwheels_viewer.panels.segments import Segments
from intellwheels_viewer.panels.selected import SelectedPanel
from intellwheels_viewer.placing_click import PlacingClick
from intellwheels_viewer.pointer_hover import PointerHover
from intellwheels_viewer.run_control import RunControl, step_hint
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import Driving, RequestQueue
from intellwheels_viewer.undo import UndoStack
from intellwheels_viewer.video_recording import VideoRecording

if TYPE_CHECKING:
    from intellwheels_viewer.html_recording import HtmlRecording
    from intellwheels_viewer.palette import Colours

MODES: Final[dict[str, Mode]] = {
    "Free (O)": "free", "Plan (P)": "plan", "Follow selected (F)": "follow", "From the chair (H)": "first",
}  # fmt: skip
"""Camera modes by label; a label ends with its key."""
LABELS: Final = {mode: label for label, mode in MODES.items()}


class Page:
    """The page of a connected browser.

    Args:
        client: The browser.
        network: Takes requests and inputs.
        colours: The colour of each agent.
        visit: How the browser has come, and what its user may do.
        dark: Whether the viewer was told to use the dark theme.
        recorder: Begins a recording; gets whether it is dark. Without it the page records nothing.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        network: Worlds,
        colours: Colours,
        visit: PageRights = EVERYTHING,
        *,
        dark: bool = False,
        recorder: Callable[[bool], HtmlRecording] | None = None,
    ) -> None:
        self._client, self._colours = client, colours
        self._visit = self._rights = visit
        self._network = network = LimitedWorlds(network, lambda: self._visit)
        # First, because it waits for the browser.
        self._layers = LayerVisibility(client, dark=dark)
        theme = stored_theme(client)
        notices = PageNotices(client)
        self._notify = notices.tell
        self._requests = RequestQueue(network, notices.refused)
        self._driving = Driving(network, self._requests)
        self._snapshot = Snapshot()
        self.selected: str | None = None
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
        self._own = OwnDrawings(client, lambda: self.camera.picture)
        self._recording = PageRecording(client, recorder, self._notify)
        self._video = VideoRecording(client, self._notify)
        self._arrival = PageArrival(self._notify)
        self._side = client.gui.add_panel()
        self._window = PageWindow(client, self.camera, self._side, dark=dark, theme=theme)
        self._build(client.gui)

    def close(self) -> None:
        """The browser has left."""
        self._video.close()
        self._driving.close()
        self._requests.close()

    def join(self, seconds: float) -> None:
        """Wait after `close` until all requests were sent, at most this many seconds."""
        self._requests.join(seconds)

    @property
    def view_state(self) -> tuple[object, ...]:
        """The choices of this browser that affect the drawing; a change redraws even a paused run."""
        return self.selected, self.camera.mode, self._layers.layers, self.camera.turning, self._window.is_dark

    @property
    def shows_all_wedges(self) -> bool:
        """Whether this browser shows, or records, the wedges of all agents."""
        return self._layers.layers.all_wedges or self._recording.runs

    @property
    def records(self) -> bool:
        """Whether this browser records."""
        return self._recording.runs

    def drawn(self, snapshot: Snapshot) -> None:
        """Record the snapshot that was just drawn, if this browser records."""
        self._recording.drawn(snapshot)
        self._video.drawn(snapshot)

    # ------------------------------------------------------------ output, on the drawing thread

    def draw(self, snapshot: Snapshot) -> None:
        """Update what moves in this browser: the selection ring and a following camera. Once per drawn tick."""
        self._snapshot = snapshot
        selected = self.selected
        entity = None if selected is None else snapshot.entity(selected)
        body = snapshot.bodies.get(selected or "")
        with self._client.atomic():
            layers, inside = self._layers.layers, entity if self.camera.mode == "first" else None
            # The own ring would be in the way of who looks down.
            self._ring.show(None if body is None or inside is not None else body.robot, entity)
            if body is not None:
                self.camera.eye = eye_of(body.robot, layers.eye_height, layers.field_of_view)
            if entity is not None:
                self.camera.follow(entity)
            if snapshot.floor is not None and snapshot.revision != self._framed:
                self._framed = snapshot.revision
                self.camera.frame(snapshot.floor)
            self._layers.dark = self._inside.dark = self._window.is_dark
            cut: frozenset[int] = frozenset()
            if self.camera.mode == "follow" and entity is not None and (picture := self.camera.picture) is not None:
                cut = self._layers.hiding(snapshot, picture.position, entity)
            self._layers.draw_walls(snapshot, inside=inside is not None, cut=cut)
            self._own.seen = self._inside.show(snapshot, inside, self.camera.eye, full_walls=layers.full_walls)
            self._own.draw(snapshot, selected, layers)

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
            self._shell.show(snapshot, choices)
            self._tools.content = tools_html(recording=self._recording.runs, video=self._video.runs)
            self._theme.show(self._window.theme)
            assign(self._views, LABELS[self.camera.mode])
            # While the run stands, the camera may move.
            self._own.label(snapshot, self.selected, self._layers.layers)
        self._arrival.arrive(self, snapshot)

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
        self._shell = PageShell(gui, self._act, self._resized)
        side = self._side
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
            self._tools = gui.add_html(tools_html(recording=False))
            self._plan = PlanPanel(gui, on_select=self.select)
            self._events = EventsPanel(gui)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(WIDTH)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Agents"):
            self._agents = AgentsPanel(gui, on_select=self.select)
            self._selected = SelectedPanel(gui)
        with tabs.add_tab("Layers"):
            self._theme = Segments(gui, "Theme", THEMES, self._window.choose)
            self._layers_panel = LayersPanel(
                gui,
                self._layers.layers,
                self._layers.choose,
                legend=legend_html(wedges.legend(), real_badge.legend()),
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
            add(f"Camera: {label[:-4].lower()}", label[-2], partial(self.look, mode))
        for digit in range(1, 10):
            add(f"Select agent {digit}", str(digit), self._selector(digit - 1))

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

    # ------------------------------------------------------------ the window, links and recordings

    def _resized(self, window: Window) -> None:
        self._window.changed(window)
        self._arrival.read(window.query)

    def _act(self, act: str) -> None:
        if act == "pause":
            self._toggle()
        elif act == "record":
            self._recording.toggle(dark=self._window.is_dark)
        elif act == "video":
            self._video.toggle()
        elif act == "link":
            eye, to = (None, None) if (picture := self.camera.picture) is None else (picture.position, picture.look_at)
            self._shell.copy_link(query_of(PageLink(self.camera.mode, self.selected, self._snapshot.tick, eye, to)))
            self._notify("Link copied", "It is also in the address bar: this camera, selection and tick.")

    def seek(self, tick: int) -> None:
        """Move a playback to a tick."""
        self._run_control.seek(tick)
