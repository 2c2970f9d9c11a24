"""The scene of all browsers: whatever is seen can be drawn, and drawing it again and again piles nothing up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Map, Pose, Robot
from intellwheels_viewer.origin_guard import open_server
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.stage import FEW, LAYERS, Stage, background, watched
from tests.bench.feed import body as feed_body
from tests.bench.feed import measures as feed_measures
from tests.viewer.browser import opened
from tests.viewer.panels import made_up
from tests.viewer.wire import RUN, body, entity

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    made = open_server("127.0.0.1", 0)
    yield made
    made.stop()


@pytest.fixture
def stage(server: viser.ViserServer) -> Stage:
    return Stage(server)


def nodes(server: viser.ViserServer) -> int:
    return len(server._websock_server._broadcast_buffer.message_from_id)


EMPTY = Map(format="iw.v1", name="empty")
CROWD = Snapshot(
    phase="live", run=RUN, tick=4, time=0.2,
    entities=tuple(entity(f"n{k:03d}", k * 1.0) for k in range(FEW + 1)),
    bodies={f"n{k:03d}": body(f"n{k:03d}") for k in range(FEW + 1)},
)  # fmt: skip


@pytest.mark.parametrize(
    "snapshot",
    [
        Snapshot(), Snapshot(floor=EMPTY, revision=0), made_up.snapshot(), made_up.hostile(), CROWD,
        # A mind's form of a robot says nothing of its body.
        Snapshot(
            entities=(entity("a"),), bodies={"a": body("a", length=None, width=None, center=None, top=None, part=())}
        ),
        Snapshot(entities=(entity("a"),)),
        Snapshot(bodies={"gone": body("gone")}),
        replace(made_up.snapshot(), entities=()),
        replace(made_up.snapshot(), bodies={}),
        replace(made_up.snapshot(), measures={}), replace(made_up.snapshot(), tick=0, time=0.0),
    ],
)  # fmt: skip
def test_whatever_is_seen_is_drawn(stage: Stage, snapshot: Snapshot) -> None:
    stage.show(snapshot, ())
    stage.show(made_up.snapshot(), {"chair1", "no such", ""})
    stage.show(snapshot, {"chair1"})


def test_a_body_that_has_no_more_than_a_name_is_drawn(stage: Stage) -> None:
    from intellwheels_schemas.messages import Body

    bare = Body(run=RUN, tick=0, robot=Robot(name="a"))
    stage.show(Snapshot(entities=(entity("a"),), bodies={"a": bare}), {"a"})


def test_bodies_stand_where_the_state_says(server: viser.ViserServer, stage: Stage) -> None:
    snapshot = Snapshot(entities=(entity("a", 1.5, -2.25), entity("b", 3.0)), bodies={"a": body("a"), "b": body("b")})
    stage.show(snapshot, ())
    ((name, names),) = [(n, who) for n, who in stage.bodies.names.items() if n.endswith("/paint")]
    assert names == ("a", "b")
    handle = server.scene._handle_from_node_name[name]
    assert np.asarray(handle.batched_positions) == pytest.approx(  # type: ignore[attr-defined]
        np.array([(1.5, -2.25, 0.0), (3.0, 0.0, 0.0)])
    )


def test_hundreds_of_ticks_leave_no_more_behind_than_a_few(server: viser.ViserServer, stage: Stage) -> None:
    def run(first: int, last: int) -> None:
        for tick in range(first, last):
            moved = tuple(entity(f"n{k}", k + tick * 0.01, say=f"word {tick // 40}" if k == tick % 3 else None)
                          for k in range(5 if tick % 7 else 4))  # fmt: skip
            bodies = {each.name: body(each.name) for each in moved}
            stage.show(Snapshot(run=RUN, tick=tick, time=tick * 0.05, entities=moved, bodies=bodies), {"n1"})

    run(1, 100)
    before = nodes(server)
    run(100, 300)
    assert nodes(server) <= before


def test_a_floor_is_drawn_once_and_another_one_anew(server: viser.ViserServer, stage: Stage) -> None:
    drawn: list[Map] = []
    show = stage._floor.show

    def noted(map: Map) -> None:  # noqa: A002
        drawn.append(map)
        show(map)

    stage._floor.show = noted  # type: ignore[method-assign]
    room = made_up.snapshot()
    for _ in range(3):
        stage.show(room, ())
    stage.show(replace(room, floor=EMPTY, revision=room.revision + 1), ())
    assert [floor.name for floor in drawn] == [room.floor.name if room.floor else "", "empty"]


@pytest.mark.process
def test_every_layer_has_a_node_that_a_browser_can_hide(server: viser.ViserServer, stage: Stage) -> None:
    with opened(server.get_port()) as browser:
        browser.wait(lambda: browser.scene >= set(LAYERS.values()))


def test_of_few_everybodys_sensors_are_drawn_of_many_those_that_somebody_selected() -> None:
    few = Snapshot(entities=CROWD.entities[:FEW])
    assert watched(few, ()) == {each.name for each in few.entities}
    assert watched(CROWD, ()) == frozenset()
    assert watched(CROWD, {"n003"}) == {"n003"}


@pytest.mark.parametrize("name", ["", "*", "a/b", "../x", "x" * 10_000, "nobody", "<img src=x onerror=1>"])
def test_a_selected_text_that_is_nobody_is_not_watched(name: str) -> None:
    assert watched(CROWD, {name, "n000"}) == {"n000"}


def test_the_background_is_plain() -> None:
    assert background((1, 2, 3)).shape == (2, 2, 3)
    assert (background((1, 2, 3)) == (1, 2, 3)).all()


@pytest.mark.process
def test_a_click_names_the_browser_and_the_body(server: viser.ViserServer, stage: Stage) -> None:
    picked: list[tuple[int, str]] = []
    stage.on_pick(lambda number, name: picked.append((number, name)))
    stage.show(Snapshot(entities=(entity("a"), entity("b")), bodies={"a": body("a"), "b": body("b")}), ())
    (node,) = [name for name in stage.bodies.names if name.endswith("/paint")]
    with opened(server.get_port()) as browser:
        browser.wait(lambda: node in browser.scene)
        click = {
            "type": "SceneNodeClickMessage", "name": node, "ray_origin": (0.0, 0.0, 1.0),
            "ray_direction": (0.0, 0.0, -1.0),
            "screen_pos": (0.5, 0.5), "modifier": None, "owner": "",
        }  # fmt: skip
        for index in (7, -1, None, 1):
            browser.send({**click, "instance_index": index})
        # What the loop has taken before is in the list once this has been answered.
        from tests.viewer.wire import until

        until(lambda: picked)
    assert [name for _, name in picked] == ["b"]


def test_of_many_only_the_selected_ones_readings_have_arcs(stage: Stage) -> None:
    names = [each.name for each in CROWD.entities[:40]]
    crowd = replace(
        CROWD, entities=CROWD.entities[:40],
        bodies={name: feed_body(name) for name in names}, measures={name: feed_measures(1, 0) for name in names},
    )  # fmt: skip
    stage.show(crowd, {"n003"}, wedges=True)
    handle = stage._wedges._bars.handle
    assert handle is not None
    few = len(handle.batched_positions)
    stage.show(replace(crowd, entities=crowd.entities[:4]), (), wedges=True)
    assert len(handle.batched_positions) == 4 * few


def test_the_ghost_of_a_reported_pose_stands_beside_the_truth(server: viser.ViserServer, stage: Stage) -> None:
    snapshot = Snapshot(entities=(entity("a", 1.5),), bodies={"a": body("a")})
    stage.show(replace(snapshot, reported={"a": Pose(x=1.0, y=0.5, heading=0.0)}), ())
    ghost = server.scene._handle_from_node_name["/reported/a/body"]
    assert ghost.position == pytest.approx([1.0, 0.5, 0.0])
    stage.show(snapshot, ())
    assert not ghost.visible
