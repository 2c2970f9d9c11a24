"""One browser's page: what it selects, wishes, places and drives, from messages as a page would send them."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
import viser

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import (
    Delete,
    OperatorSay,
    Pause,
    Record,
    Result,
    Resume,
    Spawn,
    Step,
    Take,
    Teleport,
    UserInput,
)
from intellwheels_viewer.guard import open_server
from intellwheels_viewer.page import LAYERS_KEY, MODES, Page
from intellwheels_viewer.palette import Colours
from intellwheels_viewer.panels.place import PALETTE
from intellwheels_viewer.seen import Seen
from intellwheels_viewer.steering import Refusal
from tests.viewer.browser import Browser, opened
from tests.viewer.panels import made_up
from tests.viewer.wire import body, clock, entity, until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")
SEEN = replace(
    made_up.seen(), entities=(entity("a", 1.0, 1.0), entity("b", 4.0, 1.0)), bodies={"a": body("a"), "b": body("b")}
)
DOWN = (0.0, 0.0, -1.0)


class Network:
    """Keeps what it is asked, and grants it or not."""

    def __init__(self) -> None:
        self.asked: list[tuple[Verb, Record]] = []
        self.puts: list[tuple[str, UserInput]] = []
        self.worlds: list[str] = []
        self.refuses = ""
        self.quiet = 0.0

    def ask(self, verb: Verb, wish: Record) -> Result:
        self.asked.append((verb, wish))
        if self.refuses:
            raise Refusal(self.refuses)
        return Result(code="ok", lease="0" * 16)

    def put_user(self, agent: str, wish: UserInput) -> None:
        self.puts.append((agent, wish))

    def choose(self, world: str) -> None:
        self.worlds.append(world)

    def wished(self) -> Record:
        """Wait for the newest wish."""
        until(lambda: self.asked)
        return self.asked[-1][1]


class Opened:
    """A page with its browser."""

    def __init__(self, server: viser.ViserServer, browser: Browser) -> None:
        self.network, self.browser = Network(), browser
        (client,) = until(lambda: list(server.get_clients().values()))
        self.client = client
        self.page = Page(client, cast(Any, self.network), Colours())
        self.show(SEEN)

    def show(self, seen: Seen) -> None:
        self.page.draw(seen)
        self.page.panels(seen)

    def drag(self, name: str, *steps: tuple[str, tuple[float, float]]) -> None:
        """Drag a body from where it stands."""
        stood = SEEN.entity(name)
        assert stood is not None
        for phase, (x, y) in steps:
            event = SimpleNamespace(phase=phase, start_position=(stood.x, stood.y, 0.0), end_position=(x, y, 0.0))
            self.page.drag(name, cast(Any, event))

    def ghost(self) -> bool:
        return self.page._ghost is not None


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        made = open_server("127.0.0.1", 0)
        yield made
        made.stop()


@pytest.fixture
def here(server: viser.ViserServer) -> Iterator[Opened]:
    with opened(server.get_port()) as browser:
        made = Opened(server, browser)
        yield made
        made.page.close()
        made.page.join(5.0)
    until(lambda: not server.get_clients())


# ---------------------------------------------------------------- selecting and looking


def test_following_needs_somebody_and_says_so(here: Opened) -> None:
    here.page.look("follow")
    assert here.page.camera.mode == "free"
    here.browser.wait(lambda: any("Nothing selected" in str(message) for message in here.browser.heard))


def test_a_selected_chair_is_followed_and_nobody_ends_it(here: Opened) -> None:
    here.page.select("a")
    here.page.look("follow")
    assert here.page.camera.mode == "follow"
    here.page.select("b")
    assert (here.page.selected, here.page.camera.mode) == ("b", "follow")
    here.page.select(None)
    assert str(here.page.camera.mode) == "free"


def test_every_way_to_look_is_in_the_list_and_all_modes_are_drawn(here: Opened) -> None:
    here.page.select("a")
    for label, mode in MODES.items():
        here.browser.enter("Camera", label)
        until(lambda mode=mode: here.page.camera.mode == mode)  # type: ignore[misc]
        here.show(SEEN)


def test_a_way_to_look_that_there_is_not_is_free(here: Opened) -> None:
    here.page.select("a")
    here.page.look("plan")
    here.browser.enter("Camera", "<script>")
    until(lambda: here.page.camera.mode == "free")


def test_what_decides_what_is_drawn_is_told(here: Opened) -> None:
    before = here.page.outlook
    here.page.select("a")
    assert here.page.outlook != before


def test_a_selection_outlives_the_one_who_was_selected(here: Opened) -> None:
    here.page.select("a")
    here.page.look("first")
    here.show(replace(SEEN, entities=(), bodies={}))
    here.show(Seen())
    here.show(SEEN)
    assert here.page.selected == "a"


def test_the_mode_may_change_while_the_panels_are_filled(here: Opened) -> None:
    faults: list[Exception] = []
    done = threading.Event()

    def choose() -> None:
        while not done.is_set():
            for mode in ("first", "free", "follow", "plan"):
                here.page.camera.choose(cast(Any, mode), SEEN.entities[0])

    choosing = threading.Thread(target=choose)
    choosing.start()
    try:
        for _ in range(40):
            here.show(SEEN)
    except Exception as fault:
        faults.append(fault)
    done.set()
    choosing.join(10.0)
    assert faults == []


# ---------------------------------------------------------------- wishes


def test_space_pauses_what_runs_and_resumes_what_stands(here: Opened) -> None:
    here.page._pause_or_resume()
    assert here.network.wished() == Pause()
    here.network.asked.clear()
    here.show(replace(SEEN, clock=clock(state="paused")))
    here.page._pause_or_resume()
    assert here.network.wished() == Resume()


@pytest.mark.parametrize(("label", "wish"), [("Pause", Pause()), ("Resume", Resume()), ("Remove", Delete(agent="a"))])
def test_a_button_is_a_wish(here: Opened, label: str, wish: Record) -> None:
    here.page.select("a")
    matches = [each for each in here.browser.gui.values() if str(each.get("label", "")).startswith(label)]
    assert matches or here.browser.element(label)
    uuid = next(key for key, each in here.browser.gui.items() if str(each.get("label", "")).startswith(label))
    here.browser.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})
    assert here.network.wished() == wish


def test_a_refusal_is_shown_with_its_reason_and_as_text(here: Opened) -> None:
    here.network.refuses = made_up.ATTACK
    here.page._step_one()
    assert here.network.wished() == Step(count=1)
    here.browser.wait(lambda: any("Not stepped" in str(message) for message in here.browser.heard))
    here.show(SEEN)
    here.browser.wait(lambda: "Not stepped" in here.browser.text())
    assert "<img src=x:" not in here.browser.text()
    assert "&lt;img src=x:" in here.browser.text()


def test_no_text_of_an_agent_is_markup(here: Opened) -> None:
    here.page.select(made_up.ATTACK)
    here.page._refusal = made_up.ATTACK
    here.show(made_up.hostile())
    here.browser.wait(lambda: "&lt;img src=x:" in here.browser.text())
    assert "<img src=x:" not in here.browser.text()


def test_words_are_said_to_one_or_all(here: Opened) -> None:
    here.page._say("hello", None)
    assert here.network.wished() == OperatorSay(text="hello")


# ---------------------------------------------------------------- driving


def test_the_stick_drives_who_is_selected_and_a_closed_page_stops(here: Opened) -> None:
    here.page._stick(0.5, 0.0, 1)
    assert here.network.puts == []
    here.page.select("a")
    until(lambda: here.page._stick(0.5, 0.0, 2) or here.network.puts)  # type: ignore[func-returns-value]
    assert here.network.puts[0][0] == "a"
    here.page.select("b")
    assert (here.network.puts[-1][0], here.network.puts[-1][1].forward) == ("a", 0.0)
    until(lambda: here.page._stick(0.5, 0.0, 3) or here.network.puts[-1][0] == "b")  # type: ignore[func-returns-value]
    here.page.close()
    assert here.network.puts[-1][1].forward == 0.0
    here.page.join(5.0)
    assert here.network.asked[-1] == ("take", Take(agent="b", lease="0" * 16, seconds=0.0))


# ---------------------------------------------------------------- placing and dragging


def test_what_is_placed_is_shown_then_wished_where_the_floor_was_clicked(here: Opened) -> None:
    label = next(iter(PALETTE))
    here.page._choose(label)
    assert here.ghost()
    here.page._turned(90.0)
    here.page._clicked((2.0, 3.0))
    wish = here.network.wished()
    assert isinstance(wish, Spawn)
    assert wish.position is not None
    assert (wish.position.x, wish.position.y) == (2.0, 3.0)
    assert wish.position.heading == pytest.approx(math.pi / 2)
    assert wish.robot.name == f"{PALETTE[label]}1"
    until(lambda: not here.ghost())


def test_what_may_not_stand_there_turns_red_and_stays_to_be_placed_elsewhere(here: Opened) -> None:
    here.network.refuses = "overlaps a wall"
    here.page._choose(next(iter(PALETTE)))
    here.page._clicked((2.0, 3.0))
    until(lambda: here.page._ghost is not None and here.page._ghost.refused)


def test_a_turn_that_is_no_number_turns_nothing(here: Opened) -> None:
    here.page._choose(next(iter(PALETTE)))
    for value in (math.nan, math.inf):
        here.page._turned(value)
    assert here.page._turn == 0.0
    here.page._clicked(None)
    here.page._choose("no such thing")
    assert not here.ghost()
    assert here.network.asked == []


def test_a_dragged_body_is_asked_to_go_and_only_a_ghost_moves(here: Opened) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (2.0, 1.5)))
    assert here.ghost()
    assert here.network.asked == []
    here.drag("a", ("end", (3.0, 2.0)))
    wish = here.network.wished()
    assert isinstance(wish, Teleport)
    assert wish.agent == "a"
    assert (wish.position.x, wish.position.y) == pytest.approx((3.0, 2.0))
    until(lambda: not here.ghost())


def test_a_body_that_was_hardly_pulled_stays(here: Opened) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (1.01, 1.0)), ("end", (1.01, 1.0)))
    assert here.network.asked == []


def test_a_body_that_vanishes_while_it_is_dragged_is_let_go(here: Opened) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (2.0, 1.5)))
    here.show(replace(SEEN, entities=(), bodies={}))
    here.drag("a", ("update", (2.5, 1.5)), ("end", (3.0, 2.0)))
    assert not here.ghost()
    assert here.network.asked == []


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_drag_to_nowhere_moves_nothing(here: Opened, bad: float) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (bad, 1.5)), ("end", (2.0, bad)))
    assert here.network.asked == []


def test_a_goal_is_only_for_a_mind_that_takes_goals(here: Opened) -> None:
    here.page._aim()
    here.page.select("a")
    here.page._aim()
    here.page._clicked((1.0, 1.0))
    assert here.network.puts == []
    here.show(replace(SEEN, bodies={"a": body("a", user_input=("goal",))}))
    here.page._aim()
    here.page._clicked((2.5, 1.5))
    ((agent, wish),) = here.network.puts
    assert agent == "a"
    assert wish.goal is not None
    assert (wish.goal.x, wish.goal.y) == (2.5, 1.5)


def test_hands_and_answers_move_the_ghost_at_once_without_harm(here: Opened) -> None:
    faults: list[Exception] = []

    def hand(shift: float) -> None:
        try:
            for step in range(60):
                here.page._choose(list(PALETTE)[step % len(PALETTE)])
                here.page._preview(step * 0.01 + shift, 1.0)
                here.page._redden()
                here.page._show_ghost(None)
        except Exception as fault:
            faults.append(fault)

    hands = [threading.Thread(target=hand, args=(shift,)) for shift in (0.0, 0.5)]
    for each in hands:
        each.start()
    for each in hands:
        each.join(30.0)
    assert faults == []


# ---------------------------------------------------------------- layers, other pages, the end


def test_a_layer_that_was_hidden_is_hidden_the_next_time(server: viser.ViserServer) -> None:
    stored = replace(made_up_layers(), wedges=False).to_json()
    with opened(server.get_port(), storage=stored) as browser:
        made = Opened(server, browser)
        browser.wait(lambda: "/wedges" in browser.scene)
        assert set(made.page._hidden) == {"wedges"}
        made.page.close()
    until(lambda: not server.get_clients())


@pytest.mark.parametrize("stored", ["", "{", "[]", '{"wedges": 7}', "null", "x" * 100_000])
def test_nonsense_that_a_browser_kept_is_as_nothing(server: viser.ViserServer, stored: str) -> None:
    with opened(server.get_port(), storage=stored) as browser:
        made = Opened(server, browser)
        made.page.close()
    until(lambda: not server.get_clients())


def test_a_layer_is_kept_by_the_browser(here: Opened) -> None:
    here.page._relayer(replace(made_up_layers(), trails=False))
    here.browser.wait(lambda: any(message.get("key") == LAYERS_KEY for message in here.browser.heard))


def test_a_page_that_has_left_can_still_be_drawn_to(server: viser.ViserServer) -> None:
    with opened(server.get_port()) as browser:
        made = Opened(server, browser)
    until(lambda: not server.get_clients())
    made.show(replace(SEEN, tick=SEEN.tick + 1))
    made.page.close()
    made.page.join(5.0)
    made.show(SEEN)


def made_up_layers() -> Any:
    from intellwheels_viewer.panels.layers import Layers

    return Layers()
