"""A real simulator process on loopback, spoken to by a client that knows zenoh and the contract only."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zenoh

from intellwheels_maps import robot
from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.keys import AGENT_VERBS, Keys
from intellwheels_schemas.messages import (
    Actions,
    Body,
    Clock,
    Error,
    Events,
    Joined,
    Map,
    Measures,
    Refused,
    Result,
    Take,
    WorldState,
)
from intellwheels_server.service.simulator_peer import endpoint_words, steady_unix_time

pytestmark = pytest.mark.process

DEADLINE = 20.0
KEYS = Keys("main")


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Server:
    """A simulator process; its lines are read as they come."""

    def __init__(self, *options: str, endpoint: str | None = None, connect: str | None = None) -> None:
        self.endpoint = endpoint or f"tcp/127.0.0.1:{free_port()}"
        route = ["--connect", connect] if connect else ["--listen", self.endpoint]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "intellwheels_server", *route, *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def line(self) -> str:
        """Return the next line on standard output; the process's own deadlines, or the watchdog, end the wait."""
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str, float]:
        """Send a signal and return exit code, standard error, and how long it took."""
        self.process.send_signal(number)
        began = time.monotonic()
        _, errors = self.process.communicate(timeout=DEADLINE)
        return self.process.returncode, errors, time.monotonic() - began


@contextmanager
def serving(*options: str, **more: Any) -> Iterator[Server]:
    server = Server(*options, **more)
    watchdog = threading.Timer(2 * DEADLINE, server.process.kill)
    watchdog.start()
    try:
        assert server.line().startswith("ready world=main run=")
        yield server
    finally:
        watchdog.cancel()
        if server.process.poll() is None:
            server.process.kill()
        server.process.communicate()


class Client:
    """An agent, to the letter of the contract."""

    def __init__(self, session: zenoh.Session, agent: str = "chair1", instance: str = "a" * 16) -> None:
        self.session = session
        self.agent = agent
        self.instance = instance
        self.inbox = zenoh_inbox.Inbox()
        self.subscriber: Any = session.declare_subscriber(KEYS.outs(agent), self.inbox.on_sample)
        self.token: Any = link.declare_token(session, KEYS.token(agent, "both", instance))
        self.publisher: Any = session.declare_publisher(KEYS.actions(agent))
        self.encoding = Encoding.JSON
        self.joined: Joined | None = None
        self.errors: list[Error] = []

    def ask_to_join(self, encoding: Encoding = Encoding.JSON) -> link.Answer:
        self.encoding = encoding
        wanted = msgspec.structs.replace(robot("rear-wheel"), name=self.agent, instance=self.instance, format=None)
        return link.query(self.session, KEYS.join(self.agent), encode(wanted, encoding), encoding)[0]

    def join(self, encoding: Encoding = Encoding.JSON) -> Joined:
        answer = self.ask_to_join(encoding)
        assert answer.ok, answer
        assert answer.encoding == encoding.value
        self.joined = decode(Joined, answer.data, encoding)
        return self.joined

    def measures(self) -> Measures:
        """Return the newest measures, waiting for them."""
        deadline = time.monotonic() + DEADLINE
        while time.monotonic() < deadline:
            self.inbox.wait(0.2)
            newest = None
            for arrival in self.inbox.take():
                assert isinstance(arrival, zenoh_inbox.Put)
                encoding = Encoding(arrival.encoding)
                if arrival.key == KEYS.measures(self.agent):
                    newest = decode(Measures, arrival.data, encoding, strict=False)
                elif arrival.key == KEYS.error(self.agent):
                    self.errors.append(decode(Error, arrival.data, encoding, strict=False))
            if newest is not None:
                return newest
        raise AssertionError("no measures came")

    def error(self) -> Error:
        """Return the newest error, waiting for it."""
        deadline = time.monotonic() + DEADLINE
        while not self.errors and time.monotonic() < deadline:
            self.inbox.wait(0.2)
            for arrival in self.inbox.take():
                assert isinstance(arrival, zenoh_inbox.Put)
                if arrival.key == KEYS.error(self.agent):
                    self.errors.append(decode(Error, arrival.data, Encoding(arrival.encoding), strict=False))
        return self.errors.pop()

    def drive(self, ticks: int) -> int:
        """Answer so many ticks and return the last."""
        assert self.joined is not None
        tick = -1
        for seq in range(ticks):
            while (measures := self.measures()).tick <= tick:
                pass
            tick = measures.tick
            actions = Actions(
                run=measures.run, session=self.joined.session, tick=tick, seq=seq, left_motor=0.5, right_motor=0.4
            )
            self.publisher.put(encode(actions, self.encoding), encoding=zenoh.Encoding(self.encoding.value))
        return tick


@contextmanager
def connected(server: Server) -> Iterator[zenoh.Session]:
    session = link.open_session(link.Link(connect=(server.endpoint,)), threading.Event(), timeout=DEADLINE)
    assert session is not None
    with session:
        yield session


def ask(session: zenoh.Session, key: str, data: bytes | None = None, encoding: Encoding = Encoding.JSON) -> link.Answer:
    return link.query(session, key, data, encoding)[0]


def result(session: zenoh.Session, verb: Any, data: bytes | None = None) -> Result:
    agent = json.loads(data or b"{}").get("Agent") if verb in AGENT_VERBS else None
    return decode(Result, ask(session, KEYS.ctl(verb, agent), data).data)


def test_agent_joins_answers_20_ticks_and_leaves_and_the_log_runs_again(tmp_path: Path) -> None:
    log = tmp_path / "run.jsonl"
    with serving("--pace", "lockstep", "--expect", "chair1", "--log", str(log)) as server, connected(server) as session:
        client = Client(session)
        joined = client.join()
        assert server.line().startswith("running tick=0 run=")
        assert client.drive(20) == 19
        assert client.measures().tick == 20
        state = decode(WorldState, ask(session, KEYS.every_state).data)
        assert [entity.name for entity in state.entity] == ["chair1"]
        leave = decode(Result, ask(session, KEYS.leave("chair1"), b'{"Session":"%s"}' % joined.session.encode()).data)
        assert leave.code == "ok"
        assert leave.tick is not None
        assert leave.tick in (20, 21)
        code, errors, seconds = server.end()
        assert code == 0, errors
        assert seconds < 1.0
    again = subprocess.run(
        [sys.executable, "-m", "intellwheels_server", "--resimulate", str(log)],
        capture_output=True, text=True, timeout=DEADLINE, check=False,
    )  # fmt: skip
    assert again.returncode == 0, again.stderr
    assert again.stdout.startswith(f"same ticks={leave.tick} tick={leave.tick} hash=")


def test_queries_are_answered_in_their_own_encoding() -> None:
    with serving("--pace", "lockstep") as server, connected(server) as session:
        client = Client(session)
        client.join(Encoding.XML)
        assert client.drive(3) == 2
        for encoding in (Encoding.JSON, Encoding.XML):
            for key, cls in ((KEYS.map, Map), (KEYS.event, Events), (KEYS.body("chair1"), Body), (KEYS.clock, Clock)):
                answer = ask(session, key, encoding=encoding)
                assert answer.encoding == encoding.value
                decode(cls, answer.data, encoding)
        refused = ask(session, KEYS.ctl("speed"), b"<Speed/>", Encoding.XML)
        assert not refused.ok
        assert decode(Result, refused.data, Encoding.XML).code == "failed"


def test_shared_messages_have_an_encoding_that_the_tools_of_zenoh_print() -> None:
    with serving() as server, connected(server) as session:
        inbox = zenoh_inbox.Inbox()
        found: dict[str, str] = {}
        with contextlib.ExitStack() as stack:
            for key in (KEYS.clock, KEYS.event, KEYS.every_body, KEYS.every_state, KEYS.map):
                stack.enter_context(session.declare_subscriber(key, inbox.on_sample))
            Client(session).join()
            assert ask(session, KEYS.ctl("load"), b'{"Name":"room"}').ok
            deadline = time.monotonic() + DEADLINE
            while len(found) < 5 and time.monotonic() < deadline:
                inbox.wait(0.2)
                found |= {put.key: put.encoding for put in inbox.take() if isinstance(put, zenoh_inbox.Put)}
        keys = (KEYS.body("chair1"), KEYS.clock, KEYS.event, KEYS.map, KEYS.state(0))
        assert found == dict.fromkeys(keys, "application/json")


def test_gets_with_wildcards_bring_every_key_and_a_mistyped_key_is_told() -> None:
    with serving() as server, connected(server) as session:
        client = Client(session)
        client.join()
        single = {KEYS.clock, KEYS.event, KEYS.map}
        for selector, keys in (
            ("iw/v1/main/*", single),
            ("iw/v1/*/clock", {KEYS.clock}),
            ("iw/v1/main/**", {*single, KEYS.body("chair1"), KEYS.state(0)}),
        ):
            answers = link.query(session, selector)
            assert sorted(answer.key for answer in answers) == sorted(keys), selector
        refused = link.query(session, f"{KEYS.event}?since=abc")[0]
        assert not refused.ok
        assert decode(Result, refused.data).text == "event?since: expected a number, got 'abc'"
        session.put(f"{KEYS.prefix}in/chair1/action", b"{}")
        deadline = time.monotonic() + DEADLINE
        while not client.errors and time.monotonic() < deadline:
            client.measures()
        assert [error.where for error in client.errors] == ["in/chair1/action"]


def test_words_tell_where_it_listens_from_where_it_connects() -> None:
    assert endpoint_words(link.Link(listen=("tcp/a:1", "tcp/b:2"))) == "listen=tcp/a:1,tcp/b:2"
    assert endpoint_words(link.Link(connect=("tcp/a:1",))) == "connect=tcp/a:1"
    assert endpoint_words(link.Link(listen=("tcp/a:1",), connect=("tcp/b:2",))) == "listen=tcp/a:1 connect=tcp/b:2"
    assert endpoint_words(link.Link(config=Path("z.json5"))) == "config=z.json5"


def test_world_has_one_simulator() -> None:
    with serving() as server:
        second = Server(connect=server.endpoint)
        _, errors = second.process.communicate(timeout=DEADLINE)
        assert second.process.returncode == 1
        assert "world 'main' has a simulator already" in errors
        third = Server(endpoint=server.endpoint)
        _, errors = third.process.communicate(timeout=DEADLINE)
        assert third.process.returncode == 1
        assert "the port is in use" in errors


def test_second_agent_of_a_name_is_refused_until_the_first_is_gone() -> None:
    with serving("--grace", "20") as server, connected(server) as session:
        first = Client(session)
        first.join()
        with connected(server) as other:
            second = Client(other, instance="b" * 16)
            answer = second.ask_to_join()
            assert not answer.ok
            assert decode(Refused, answer.data).code == "already-here"
            first.token.undeclare()
            deadline = time.monotonic() + DEADLINE
            while not (answer := second.ask_to_join()).ok and time.monotonic() < deadline:
                pass
            assert answer.ok


def test_invalid_bytes_do_no_harm_and_give_errors() -> None:
    with serving() as server, connected(server) as session:
        client = Client(session)
        client.join()
        for key in ("in/chair1/actions", "in/chair1/pose", "in/chair1/say", "user/chair1"):
            for data in (b"", b"{", b"<Actions", b"\xff\xfe", b'{"LeftMotor":NaN}', b"[" * 3000):
                session.put(KEYS.prefix + key, data)
        assert client.error().code in ("malformed", "encoding", "field", "value")
        session.put(f"{KEYS.prefix}in/*/actions", b'{"LeftMotor":1.0}', encoding="application/json")
        session.delete(f"{KEYS.prefix}in/chair1/actions")
        session.put(f"{KEYS.prefix}in/chair1/actions/more", b"{}")
        session.put(f"{KEYS.prefix}in/chair1/actions", b"x" * 2_000_000)
        taken = result(session, "take", encode(Take(agent="chair1")))
        assert taken.code == "ok"
        assert result(session, "pause").code == "ok"
        state = decode(WorldState, ask(session, KEYS.state(0)).data)
        assert [entity.name for entity in state.entity] == ["chair1"]


def test_quit_ends_the_process_and_its_token_goes() -> None:
    with serving() as server, connected(server) as session:
        assert link.tokens(session, KEYS.alive) == [KEYS.alive]
        assert result(session, "quit").code == "ok"
        assert server.process.wait(timeout=DEADLINE) == 0
        assert link.tokens(session, KEYS.alive) == []


def test_missed_answer_ends_a_strict_process_with_exit_1() -> None:
    with serving("--pace", "lockstep", "--deadline", "0.3") as server, connected(server) as session:
        assert server.line().startswith("running tick=0 run=")
        Client(session).join()
        assert server.line() == "miss agent=chair1 tick=0"
        assert server.process.wait(timeout=DEADLINE) == 1


def test_closed_lifeline_ends_the_process() -> None:
    reading, writing = os.pipe()
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    process = subprocess.Popen(
        [sys.executable, "-m", "intellwheels_server", "--listen", endpoint, "--lifeline", str(reading)],
        stdout=subprocess.PIPE,
        pass_fds=(reading,),
    )
    assert process.stdout is not None
    assert process.stdout.readline().startswith(b"ready ")
    os.close(reading)
    os.close(writing)
    assert process.wait(timeout=DEADLINE) == 0
    process.communicate()


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--map", "nowhere"], "expected one of the maps"),
        (["--world", "Not A Name"], "--world: expected a name"),
        (["--speed", "2", "--pace", "lockstep"], "--speed: expected pace realtime, got lockstep"),
        (["--open-loop"], "--open-loop: expected pace free, got realtime"),
        (["--period", "7"], "--period: expected seconds"),
        (["--expect", "chair1,Bad"], "--expect"),
        (["--speed", "0"], "--speed: expected a number in (0, 1000], got '0'"),
    ],
)
def test_wrong_usage_exits_with_2(options: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    from intellwheels_server.__main__ import main

    try:
        code: Any = main(options)
    except SystemExit as exit_:
        code = exit_.code
    assert code == 2
    assert text in capsys.readouterr().err


def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    from intellwheels_server.__main__ import main

    with pytest.raises(SystemExit) as exit_:
        main(["--help"])
    assert exit_.value.code == 0
    shown = capsys.readouterr().out
    assert "iw-server --scene figure6 --log run.jsonl" in shown
    assert "--resimulate" in shown


def test_stamps_do_not_go_back_with_the_wall_clock() -> None:
    wall, steady = [7200.0], [50.0]
    now = steady_unix_time(lambda: wall[0], lambda: steady[0])
    assert now() == 7200.0
    wall[0], steady[0] = 3600.0, 51.0
    assert now() == 7201.0
