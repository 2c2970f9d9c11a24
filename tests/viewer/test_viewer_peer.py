"""The viewer on the network: what it sees of worlds that come, fall silent and go, and what hostile bytes do to it."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import msgspec
import pytest

from intellwheels_experiments.run.endpoints import free_port
from intellwheels_maps import library
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Pause, Pose, Result, Speed, UserInput
from intellwheels_viewer import viewer_peer as network_module
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import Refusal
from intellwheels_viewer.viewer_peer import Network
from tests.viewer.wire import (
    OTHER,
    RUN,
    Simulator,
    body,
    clock,
    entity,
    event,
    info,
    listening,
    measures,
    simulator,
    state,
    until,
)

pytestmark = pytest.mark.process


@contextmanager
def watching(endpoint: str, world: str = "main", *, chosen: bool = False) -> Iterator[Network]:
    stop = threading.Event()
    made = Network(Link(world, connect=(endpoint,)), stop, chosen=chosen)
    made.start()
    try:
        yield made
    finally:
        stop.set()
        made.close()
        assert made._opener is not None
        made._opener.join(10.0)
        assert not made._opener.is_alive()


def sees(network: Network, there: Callable[[Snapshot], object], what: str = "what is to be seen") -> Snapshot:
    """Update until the snapshot is so."""

    def look() -> Snapshot | None:
        snapshot = network.update()
        return snapshot if there(snapshot) else None

    found = until(look, what=what)
    assert isinstance(found, Snapshot)
    return found


@pytest.fixture
def world() -> Iterator[tuple[Simulator, Network]]:
    with simulator("lab") as (made, endpoint), watching(endpoint) as network:
        made.bodies = [body("a"), body("b")]
        made.run(3, entity("a", 1.0), entity("b", 2.0))
        sees(
            network,
            lambda snapshot: snapshot.phase == "live" and len(snapshot.entities) == 2 and snapshot.floor is not None,
        )
        yield made, network


# ---------------------------------------------------------------- whether there is anything


def test_nobody_at_the_endpoint_is_told_and_looked_for_again() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with watching(endpoint) as network:
        snapshot = network.update()
        assert (snapshot.phase, snapshot.endpoint, snapshot.worlds) == ("no-router", endpoint, ())
        with pytest.raises(Refusal, match="No simulator at tcp/"):
            network.ask("pause", Pause())
        network.put_user("a", UserInput())  # nothing to put it to


def test_an_endpoint_that_is_none_is_a_failure_in_words_that_stops() -> None:
    stop = threading.Event()
    network = Network(Link(connect=("nonsense",)), stop)
    network.start()
    assert stop.wait(10.0)
    assert "expected" in network.failure
    network.close()


def test_a_router_without_a_world_is_told() -> None:
    with listening() as (_, endpoint), watching(endpoint) as network:
        sees(network, lambda snapshot: snapshot.phase == "no-world")


def test_the_only_world_is_watched_without_being_named(world: tuple[Simulator, Network]) -> None:
    snapshot = world[1].update()
    assert (snapshot.world, snapshot.worlds) == ("lab", ("lab",))


def test_a_late_comer_asks_for_all_it_missed() -> None:
    with simulator("lab") as (made, endpoint):
        made.bodies, made.states = [body("a")], [state(7, entity("a", 1.5))]
        made.clock = clock(7, state="paused", stamp=time.time())
        made.events = [event(0), event(1, "paused")]
        with watching(endpoint) as network:
            snapshot = sees(
                network, lambda snapshot: snapshot.entities and snapshot.floor and len(snapshot.events) == 2
            )
            assert (snapshot.tick, snapshot.entities[0].x, snapshot.run) == (7, 1.5, RUN)
            assert snapshot.floor == library.floor("room")
            assert snapshot.clock == made.clock


def test_of_several_worlds_one_is_chosen() -> None:
    with simulator("lab") as (one, endpoint):
        other = Simulator(one.session, "ward")
        try:
            with watching(endpoint) as network:
                snapshot = sees(network, lambda snapshot: len(snapshot.worlds) == 2)
                assert (snapshot.phase, snapshot.world, snapshot.worlds) == ("choose", "", ("lab", "ward"))
                other.bodies = [body("w")]
                network.choose("ward")
                other.run(1, entity("w"))
                snapshot = sees(network, lambda snapshot: snapshot.world == "ward" and snapshot.entities)
                assert [each.name for each in snapshot.entities] == ["w"]
                one.run(9, entity("w"))
                network.choose("lab")
                one.bodies = [body("w", robot="mid-wheel")]
                snapshot = sees(network, lambda snapshot: snapshot.world == "lab" and snapshot.entities)
                assert snapshot.tick == 9
        finally:
            other.close()


def test_a_world_that_comes_alone_is_taken_and_kept_when_another_comes() -> None:
    with simulator("lab") as (one, endpoint), watching(endpoint) as network:
        one.run(1)
        sees(network, lambda snapshot: snapshot.world == "lab")
        other = Simulator(one.session, "ward")
        try:
            snapshot = sees(network, lambda snapshot: len(snapshot.worlds) == 2)
            assert snapshot.world == "lab"
        finally:
            other.close()


def test_reported_poses_are_heard_in_a_log_that_is_played(world: tuple[Simulator, Network]) -> None:
    made, network = world
    pose = Pose(run=RUN, session=RUN, tick=3, x=1.5, y=0.0, heading=0.0)

    def report(last: int | None) -> None:
        made.clock = msgspec.structs.replace(clock(3, stamp=time.time()), last=last)
        made.put(made.keys.clock, made.clock)
        made.put(made.keys.pose("a"), b"{")
        made.put(made.keys.pose("a"), pose)

    report(None)
    sees(network, lambda snapshot: snapshot.clock == made.clock)
    assert network.update().reported == {}

    def heard() -> bool:
        report(100)
        return network.update().reported == {"a": pose}

    until(heard)


def test_a_world_that_was_named_is_waited_for_though_another_is_there() -> None:
    with simulator("lab") as (_, endpoint), watching(endpoint, "ward", chosen=True) as network:
        snapshot = sees(network, lambda snapshot: snapshot.worlds == ("lab",))
        assert (snapshot.phase, snapshot.world) == ("choose", "ward")


def test_a_text_that_is_no_world_is_not_chosen(world: tuple[Simulator, Network]) -> None:
    for name in ("a/*", "**", "", "x" * 500):
        world[1].choose(name)
        assert world[1].update().world == "lab"


def test_a_simulator_that_goes_is_gone_and_comes_back(world: tuple[Simulator, Network]) -> None:
    made, network = world
    made.leave()
    snapshot = sees(network, lambda snapshot: snapshot.phase == "gone")
    assert len(snapshot.entities) == 2  # the last picture
    made.verdict = lambda verb, data: None
    with pytest.raises(Refusal, match="not running"):
        network.ask("pause", Pause())
    made.come()
    made.run(0, entity("a"), run=OTHER)
    made.bodies = [body("a", OTHER)]
    sees(network, lambda snapshot: snapshot.phase == "live" and snapshot.run == OTHER and len(snapshot.entities) == 1)


def test_a_clock_that_stops_is_silence(world: tuple[Simulator, Network], monkeypatch: pytest.MonkeyPatch) -> None:
    made, network = world
    assert network.quiet < network_module.SILENCE
    monkeypatch.setattr(network_module, "SILENCE", 0.2)
    sees(network, lambda snapshot: snapshot.phase == "silent")
    made.run(4, entity("a"), entity("b"))
    sees(network, lambda snapshot: snapshot.phase == "live" and snapshot.tick == 4)


def test_a_router_that_goes_is_told() -> None:
    with simulator("lab") as (made, endpoint), watching(endpoint) as network:
        sees(network, lambda snapshot: snapshot.worlds)
        made.session.close()  # type: ignore[no-untyped-call]
        sees(network, lambda snapshot: snapshot.phase == "no-router")


# ---------------------------------------------------------------- in


@pytest.mark.parametrize(("run", "tick"), [(OTHER, 0), (RUN, 2**53 - 1)])
def test_forged_world_is_not_shown(world: tuple[Simulator, Network], run: str, tick: int) -> None:
    made, network = world
    false = msgspec.structs.replace(clock(0, run, stamp=9e9), tick=tick, state="ended")
    made.put(made.keys.clock, false)
    made.put(made.keys.event, event(0, "contact", run, tick))
    made.put(made.keys.state(0), msgspec.structs.replace(state(0, entity("ghost"), run=run), tick=tick))
    made.put(made.keys.clock, clock(4, stamp=time.time()))
    made.put(made.keys.state(0), state(4, entity("a", 1.5), entity("b", 2.0)))
    shown = sees(network, lambda snapshot: snapshot.tick == 4)
    assert [one.name for one in shown.entities] == ["a", "b"]
    assert shown.clock is not None
    assert (shown.run, shown.clock.state, shown.events) == (RUN, "running", ())


def test_another_run_is_followed_once_the_simulator_confirms_it(world: tuple[Simulator, Network]) -> None:
    made, network = world
    made.bodies = [body("c", OTHER)]
    made.put(made.keys.map, info(OTHER))
    made.put(made.keys.body("c"), body("c", OTHER))
    made.run(0, entity("c"), run=OTHER)
    sees(network, lambda snapshot: [each.name for each in snapshot.entities] == ["c"])


def test_missed_events_are_asked_for(world: tuple[Simulator, Network]) -> None:
    made, network = world
    sees(network, lambda snapshot: network._world is not None and network._world.store.wants_events_since is None)
    made.events = [event(k) for k in range(6)]
    made.put(made.keys.event, event(5))
    snapshot = sees(network, lambda snapshot: len(snapshot.events) == 6)
    assert [each.number for each in snapshot.events] == list(range(6))
    assert any("since=0" in selector for selector in made.fetched)


def test_measures_are_heard_of_whom_somebody_watches(world: tuple[Simulator, Network]) -> None:
    made, network = world
    network.watch({"a"})
    tick = iter(range(4, 10_000))

    def told(snapshot: Snapshot) -> bool:
        now = next(tick)
        for name in "ab":
            made.put(made.keys.measures(name), measures(now, 1.0))
        return bool(snapshot.measures)

    assert set(sees(network, told).measures) == {"a"}
    network.watch(())
    assert network.update().measures == {}


def test_of_many_all_measures_are_heard_by_one_subscription(world: tuple[Simulator, Network]) -> None:
    made, network = world
    network.watch({f"n{k}" for k in range(network_module.WATCHED_MOST + 1)})
    assert network._world is not None
    assert set(network._world.watched) == {"*"}
    tick = iter(range(4, 10_000))

    def told(snapshot: Snapshot) -> bool:
        made.put(made.keys.measures("b"), measures(next(tick), 1.0))
        return "b" in snapshot.measures

    sees(network, told)


_HOSTILE = [
    b"", b"\x00\xff\xfe", b"{", b"{}", b"[]", b"null", b"<", b"<Clock", b"x" * 100_000, b'{"Run":1}', b"[" * 5000,
    b'{"Run":"' + b"0" * 16 + b'","Tick":-1}', b'{"Run":NaN}', b'<!DOCTYPE x [<!ENTITY a "b">]><Clock>&a;</Clock>',
    '{"Run":"\ud800"}'.encode("utf-8", "surrogatepass"),
]  # fmt: skip


def test_hostile_bytes_on_every_key_never_stop_it(world: tuple[Simulator, Network]) -> None:
    made, network = world
    network.watch({"a"})
    keys = made.keys
    every = (
        keys.clock, keys.map, keys.event, keys.state(0), keys.state(7), keys.body("a"), keys.body("z"),
        keys.measures("a"), f"{keys.prefix}state/x", f"{keys.prefix}state/-1", f"{keys.prefix}body/Ä",
    )  # fmt: skip
    encodings = ("application/json;iw.v1", "application/xml;iw.v1", "text/plain", "zenoh/bytes", "iw/2;x", "")
    dice = random.Random(1)
    for key in every:
        for data in _HOSTILE:
            made.put(key, data, dice.choice(encodings))
            network.update()

    def told(snapshot: Snapshot) -> bool:
        # Again and again: puts are dropped rather than waited for.
        made.run(50, entity("a", 5.0), entity("b"))
        return snapshot.tick == 50

    snapshot = sees(network, told)
    assert snapshot.entities[0].x == 5.0


def test_messages_of_one_kind_on_the_key_of_another_never_stop_it(world: tuple[Simulator, Network]) -> None:
    made, network = world
    every = (clock(1), info(), event(99), state(1, entity("a")), body("a"), measures(1, 1.0), library.floor("room"))
    keys = made.keys
    for key in (keys.clock, keys.map, keys.event, keys.state(0), keys.body("a")):
        for message in every:
            made.put(key, message)
    made.run(60, entity("a", 6.0), entity("b"))
    sees(network, lambda snapshot: snapshot.tick == 60 and snapshot.entities[0].x == 6.0)


def test_hostile_answers_never_stop_it() -> None:
    with simulator("lab") as (made, endpoint):
        made.floor, made.clock = None, None
        junk = made.session.declare_queryable(
            made.keys.map, lambda query: query.reply(str(query.key_expr), b"\xff{", encoding="application/json;iw.v1")
        )
        with watching(endpoint) as network:
            made.bodies = [body("a")]
            made.run(1, entity("a"))
            sees(network, lambda snapshot: snapshot.entities)
            until(lambda: (network.update(), made.fetched)[1])
            assert network.update().floor is None
        junk.undeclare()  # type: ignore[no-untyped-call]


def test_names_of_worlds_that_are_none_are_not_worlds() -> None:
    with listening() as (session, endpoint):
        tokens = [session.liveliness().declare_token(f"iw/v1/{name}/alive") for name in ("UPPER", "a b", "x" * 99)]
        made = Simulator(session, "lab")
        with watching(endpoint) as network:
            sees(network, lambda snapshot: snapshot.worlds == ("lab",))
        made.close()
        del tokens


# ---------------------------------------------------------------- out


def test_a_wish_is_answered(world: tuple[Simulator, Network]) -> None:
    made, network = world
    made.verdict = lambda verb, data: Result(code="ok", lease="0" * 16)
    assert network.ask("pause", Pause()).lease == "0" * 16
    assert made.asked == [("pause", b"{}")]


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (Result(code="incorrect-state", text="agent 'a' is taken by somebody else"), "taken by somebody else"),
        (Result(code="incorrect-state"), "pause: incorrect-state"),
        (b"\xff", "Cannot read"),
        (b'{"Code":"no such"}', "Cannot read"),
    ],
)
def test_a_refusal_is_in_words(world: tuple[Simulator, Network], answer: Result | bytes, words: str) -> None:
    made, network = world
    made.verdict = lambda verb, data: answer
    with pytest.raises(Refusal, match=words):
        network.ask("pause", Pause())


def test_who_may_only_look_hears_so(world: tuple[Simulator, Network], monkeypatch: pytest.MonkeyPatch) -> None:
    made, network = world
    monkeypatch.setattr(network_module, "ANSWER_LIMIT", 0.3)
    made.verdict = lambda verb, data: None
    with pytest.raises(Refusal, match="View only"):
        network.ask("pause", Pause())


def test_a_number_that_is_none_is_refused_here(world: tuple[Simulator, Network]) -> None:
    made, network = world
    with pytest.raises(Refusal, match="finite"):
        network.ask("speed", Speed(factor=float("nan")))
    assert made.asked == []


def test_user_input_is_put_at_once(world: tuple[Simulator, Network]) -> None:
    made, network = world
    for seq in range(5):
        network.put_user("a", UserInput(seq=seq, forward=0.5))
    until(lambda: len(made.users) == 5)
    assert [each.seq for each in made.users] == list(range(5))
    network.put_user("no / name *", UserInput(forward=1.0))
    network.put_user("a", UserInput(seq=9))
    until(lambda: len(made.users) == 6)


def test_a_question_that_is_open_when_the_viewer_ends_does_not_hold_it() -> None:
    with simulator("lab") as (made, endpoint):
        entered, go_on = threading.Event(), threading.Event()

        def verdict(verb: str, data: bytes) -> None:
            entered.set()
            go_on.wait(10.0)

        made.verdict = verdict
        heard: list[str] = []
        with watching(endpoint) as network:
            sees(network, lambda snapshot: snapshot.world)

            def ask() -> None:
                try:
                    network.ask("pause", Pause())
                except Refusal as refusal:
                    heard.append(str(refusal))

            asking = threading.Thread(target=ask)
            asking.start()
            assert entered.wait(10.0)
            began = time.monotonic()
        assert time.monotonic() - began < 2.5
        asking.join(10.0)
        go_on.set()
        assert len(heard) == 1


def test_worlds_are_changed_while_pages_put_into_them() -> None:
    with simulator("lab") as (one, endpoint):
        other = Simulator(one.session, "ward")
        try:
            with watching(endpoint, "lab", chosen=True) as network:
                sees(network, lambda snapshot: len(snapshot.worlds) == 2)
                done, faults = threading.Event(), []

                def put() -> None:
                    number = 0
                    while not done.is_set():
                        number += 1
                        try:
                            network.put_user(f"n{number % 40}", UserInput(seq=number))
                        except Exception as fault:
                            faults.append(fault)

                putting = threading.Thread(target=put)
                putting.start()
                for change in range(30):
                    network.choose("ward" if change % 2 else "lab")
                    network.update()
                done.set()
                putting.join(10.0)
                assert faults == []
        finally:
            other.close()
