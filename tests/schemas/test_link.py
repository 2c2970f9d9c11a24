from __future__ import annotations

import argparse
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zenoh

from intellwheels_schemas import defaults
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import EVERY_ALIVE, Keys
from intellwheels_schemas.link import (
    START_ONE,
    Link,
    add_link_options,
    config_of,
    declare,
    declare_token,
    link_of,
    open_session,
    query,
    tokens,
    watch_tokens,
)
from intellwheels_schemas.zenoh_inbox import Arrival, Ask, Inbox, Presence, Put, TooLong

KEYS = Keys("main")
HEX = "5f0c2a9be1d84377"
DEADLINE = 5.0


def free_endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def session_of(link: Link) -> zenoh.Session:
    session = open_session(link, threading.Event(), timeout=DEADLINE)
    assert session is not None
    return session


@pytest.fixture
def pair() -> Iterator[tuple[zenoh.Session, zenoh.Session]]:
    """A session that listens and a client of it."""
    endpoint = free_endpoint()
    with session_of(Link(listen=(endpoint,))) as server, session_of(Link(connect=(endpoint,))) as client:
        yield server, client


def take(inbox: Inbox, count: int) -> list[Arrival]:
    found: list[Arrival] = []
    while len(found) < count:
        assert inbox.wait(DEADLINE), f"only {found} came"
        found += inbox.take()
    return found


def parsed(*arguments: str, listens: bool = False) -> Link:
    parser = argparse.ArgumentParser()
    add_link_options(parser, listens=listens)
    return link_of(parser.parse_args(arguments))


# ---------------------------------------------------------------- options


def test_simulator_listens_and_others_connect_where_nothing_is_said(tmp_path: Path) -> None:
    config = tmp_path / "z.json5"
    config.write_text("{}")
    assert parsed(listens=True) == Link(listen=(defaults.ENDPOINT,))
    assert parsed() == Link(connect=(defaults.ENDPOINT,))
    assert parsed("--connect", "tcp/10.0.0.5:1", listens=True) == Link(connect=("tcp/10.0.0.5:1",))
    assert parsed("--config", str(config), "--world", "lab") == Link(world="lab", config=config)
    assert parsed("--connect", "tcp/a:1", "--connect", "tcp/b:1").connect == ("tcp/a:1", "tcp/b:1")


def test_world_that_is_no_name_is_refused() -> None:
    with pytest.raises(WireError, match=r"--world: expected a name"):
        parsed("--world", "*")


def test_endpoints_and_the_configuration_are_checked_before_zenoh_sees_them(tmp_path: Path) -> None:
    with pytest.raises(WireError, match=r"^--connect: expected an endpoint .* did you mean tcp/10\.0\.0\.5:7447\?$"):
        parsed("--connect", "http://10.0.0.5")
    with pytest.raises(WireError, match=r"^--listen: expected an endpoint such as tcp/127\.0\.0\.1:7447, got ''$"):
        parsed("--listen", "")
    config = tmp_path / "z.json5"
    config.write_text("{\n mode: 'boss' }")
    with pytest.raises(
        WireError, match=r"^--config: .*, got in line 2: unknown variant `boss`, expected one of"
    ) as wrong:
        parsed("--config", str(config))
    assert "zenoh-config" not in wrong.value.text
    with pytest.raises(SystemExit):
        parsed("--config", str(tmp_path / "none"))


def test_configuration_finds_nobody_by_itself_and_bounds_what_comes() -> None:
    config = config_of(Link(listen=("tcp/127.0.0.1:0",)))
    assert config.get_json("mode") == '"peer"'
    assert config.get_json("scouting/multicast/enabled") == "false"
    assert config.get_json("scouting/gossip/enabled") == "false"
    assert config.get_json("transport/shared_memory/enabled") == "false"
    assert config.get_json("transport/link/rx/max_message_size") == "1048576"
    assert '"data_high":16' in config.get_json("transport/link/tx/queue/size")
    assert config_of(Link(connect=("tcp/127.0.0.1:1",))).get_json("mode") == '"client"'


def test_configuration_file_is_kept_but_for_what_must_hold(tmp_path: Path) -> None:
    path = tmp_path / "zenoh.json5"
    path.write_text(
        '{mode: "router", connect: {endpoints: ["tcp/127.0.0.1:9"]}, scouting: {multicast: {enabled: true}}}'
    )
    config = config_of(Link(config=path))
    assert config.get_json("mode") == '"router"'
    assert config.get_json("connect/endpoints") == '["tcp/127.0.0.1:9"]'
    assert config.get_json("scouting/multicast/enabled") == "false"
    with pytest.raises(ConnectionError, match="expected a Zenoh configuration"):
        config_of(Link(config=tmp_path / "none.json5"))
    with pytest.raises(ConnectionError, match="expected a Zenoh configuration"):
        config_of(Link(connect=("nowhere",)))


# ---------------------------------------------------------------- opening


@pytest.mark.process
def test_taken_port_is_told_in_words() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        endpoint = f"tcp/127.0.0.1:{other.getsockname()[1]}"
        with pytest.raises(ConnectionError, match=f"cannot listen at {endpoint}: the port is in use"):
            open_session(Link(listen=(endpoint,)), threading.Event())


@pytest.mark.process
def test_waiting_for_a_router_ends_with_stop_and_with_its_time() -> None:
    link = Link(connect=(free_endpoint(),))
    stop = threading.Event()
    words: list[str] = []

    def on_waiting(text: str) -> None:
        words.append(text)
        stop.set()

    assert open_session(link, stop, waiting=on_waiting) is None
    assert words == [f"nobody answers at {link.where()}; {START_ONE}"]
    with pytest.raises(ConnectionError, match="nobody answers at"):
        open_session(link, threading.Event(), timeout=0.0)


@pytest.mark.process
def test_client_waits_for_who_listens_later() -> None:
    endpoint = free_endpoint()
    server: list[zenoh.Session] = []

    def on_waiting(_: str) -> None:
        server.append(session_of(Link(listen=(endpoint,))))

    client = open_session(Link(connect=(endpoint,)), threading.Event(), timeout=DEADLINE, waiting=on_waiting)
    assert client is not None
    with client, server[0]:
        assert not client.is_closed()


# ---------------------------------------------------------------- traffic


def joined(server: zenoh.Session, client: zenoh.Session, inbox: Inbox) -> zenoh.LivelinessToken:
    """Wait until what the client declares reaches the server: a token that comes proves it. Keep the token."""
    watch_tokens(server, KEYS.every_token, inbox)
    token = declare_token(client, KEYS.token("chair1", "both", HEX))
    assert take(inbox, 1) == [Presence(KEYS.token("chair1", "both", HEX), True)]
    return token


@pytest.mark.process
def test_samples_arrive_with_key_bytes_and_encoding_and_deletes_do_not(
    pair: tuple[zenoh.Session, zenoh.Session],
) -> None:
    server, client = pair
    inbox = Inbox(max_bytes=100)
    server.declare_subscriber(KEYS.every_in, inbox.on_sample)
    _token = joined(server, client, inbox)
    actions = declare(client, KEYS.actions("chair1"), CHANNELS["actions"], Encoding.XML)
    actions.put(b"<Actions/>")
    actions.delete()
    actions.put(b"x" * 101)
    actions.put(b"<Actions/>")
    key = KEYS.actions("chair1")
    assert take(inbox, 3) == [
        Put(key, b"<Actions/>", "application/xml"),
        TooLong(key, 101),
        Put(key, b"<Actions/>", "application/xml"),
    ]
    assert inbox.deleted == 1


@pytest.mark.process
def test_message_over_the_links_bound_does_not_arrive_and_the_link_lives(
    pair: tuple[zenoh.Session, zenoh.Session],
) -> None:
    server, client = pair
    inbox = Inbox()
    server.declare_subscriber(KEYS.every_in, inbox.on_sample)
    _token = joined(server, client, inbox)
    client.put(KEYS.say("chair1"), b"x" * 2_000_000)
    client.put(KEYS.say("chair1"), b"after")
    assert [len(put.data) for put in take(inbox, 1) if isinstance(put, Put)] == [5]


def serve(inbox: Inbox, answer: Callable[[Ask], None]) -> threading.Thread:
    def run() -> None:
        (ask,) = take(inbox, 1)
        assert isinstance(ask, Ask)
        answer(ask)
        ask.close()

    thread = threading.Thread(target=run)
    thread.start()
    return thread


@pytest.mark.process
def test_query_brings_the_reply_or_the_error_reply(pair: tuple[zenoh.Session, zenoh.Session]) -> None:
    server, client = pair
    inbox = Inbox()
    server.declare_queryable(KEYS.every_join, inbox.on_query)
    _token = joined(server, client, inbox)
    key = KEYS.join("chair1")
    thread = serve(inbox, lambda ask: ask.reply(ask.data, Encoding.XML))
    (answer,) = query(client, key, b"<Robot/>", Encoding.XML)
    thread.join()
    assert answer[:4] == (key, b"<Robot/>", "application/xml", True)
    thread = serve(inbox, lambda ask: ask.refuse(b"{}", Encoding.JSON))
    (answer,) = query(client, key, b"{}")
    thread.join()
    assert answer[:4] == ("", b"{}", "application/json", False)


@pytest.mark.process
@pytest.mark.parametrize("suffix", ["", ";iw.v1"])
def test_error_reply_of_another_simulator_may_have_the_version(
    pair: tuple[zenoh.Session, zenoh.Session], suffix: str
) -> None:
    server, client = pair
    inbox = Inbox()
    server.declare_queryable(KEYS.every_join, inbox.on_query)
    _token = joined(server, client, inbox)
    encoding = f"application/json{suffix}"
    thread = serve(inbox, lambda ask: ask.query.reply_err(b"{}", encoding=zenoh.Encoding(encoding)))
    (answer,) = query(client, KEYS.join("chair1"), b"{}")
    thread.join()
    assert answer[:4] == ("", b"{}", encoding, False)


@pytest.mark.process
def test_one_query_brings_every_part_with_its_parameters(pair: tuple[zenoh.Session, zenoh.Session]) -> None:
    server, client = pair
    inbox = Inbox()
    server.declare_queryable(KEYS.every_state, inbox.on_query)
    _token = joined(server, client, inbox)

    def answer(ask: Ask) -> None:
        assert ask.parameters == "since=3"
        for part in range(3):
            ask.reply(b"{}", Encoding.JSON, KEYS.state(part))

    thread = serve(inbox, answer)
    answers = query(client, f"{KEYS.every_state}?since=3")
    thread.join()
    assert sorted(one.key for one in answers) == [KEYS.state(part) for part in range(3)]


@pytest.mark.process
def test_query_that_nobody_answers_says_so(pair: tuple[zenoh.Session, zenoh.Session]) -> None:
    with pytest.raises(ConnectionError, match="no simulator at iw/v1/main/ctl/pause, or not allowed"):
        query(pair[1], KEYS.ctl("pause"), b"{}")


@pytest.mark.process
def test_query_that_is_never_finished_ends_with_its_time(pair: tuple[zenoh.Session, zenoh.Session]) -> None:
    server, client = pair
    inbox = Inbox()
    server.declare_queryable(KEYS.every_ctl[0], inbox.on_query)
    _token = joined(server, client, inbox)
    with pytest.raises(ConnectionError, match="no simulator at"):
        query(client, KEYS.ctl("pause"), b"{}", timeout=0.3)
    assert len(inbox.take()) == 1


@pytest.mark.process
def test_tokens_come_are_found_and_go(pair: tuple[zenoh.Session, zenoh.Session]) -> None:
    server, client = pair
    inbox = Inbox()
    assert tokens(client, EVERY_ALIVE) == []
    _alive = declare_token(server, KEYS.alive)
    assert tokens(client, EVERY_ALIVE) == [KEYS.alive]
    with watch_tokens(client, EVERY_ALIVE, inbox):
        assert take(inbox, 1) == [Presence(KEYS.alive, True)]
    watch_tokens(server, KEYS.every_token, inbox)
    key = KEYS.token("chair1", "mind", HEX)
    with declare_token(client, key):
        assert take(inbox, 1) == [Presence(key, True)]
    assert take(inbox, 1) == [Presence(key, False)]


# ---------------------------------------------------------------- the inbox alone


@pytest.mark.process
def test_full_inbox_counts_what_it_does_not_keep(pair: tuple[zenoh.Session, zenoh.Session]) -> None:
    server, client = pair
    inbox, tokens_only = Inbox(room=3), Inbox()
    server.declare_subscriber(KEYS.every_in, inbox.on_sample)
    all_here = threading.Semaphore(0)
    server.declare_subscriber(KEYS.every_in, lambda _: all_here.release())
    _token = joined(server, client, tokens_only)
    publisher = declare(client, KEYS.actions("chair1"), CHANNELS["actions"])
    for _ in range(10):
        publisher.put(b"{}")
    for _ in range(10):
        assert all_here.acquire(timeout=DEADLINE)
    kept: list[Arrival] = take(inbox, 3)
    deadline = time.monotonic() + DEADLINE
    while len(kept) + inbox.dropped < 10 and time.monotonic() < deadline:
        kept += inbox.take()
    assert len(kept) + inbox.dropped == 10
