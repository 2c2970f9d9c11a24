import datetime
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any

import pytest
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Identity, Lab, May
from intellwheels_schemas.present import main as present
from intellwheels_server.service import lab_keys
from intellwheels_server.service import router as command
from intellwheels_server.service.router import main, next_pause

DEADLINE = 30.0


def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@contextmanager
def router(address: str, *words: str, stderr: IO[str] | None = None) -> Iterator["subprocess.Popen[str]"]:
    child = subprocess.Popen(
        [sys.executable, "-m", "intellwheels_server.service.router", "--listen", address, *words],
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
        start_new_session=True,
    )
    assert child.stdout is not None
    try:
        assert child.stdout.readline() == f"ready listen={address}\n"
        yield child
    finally:
        if child.poll() is None:
            os.killpg(child.pid, signal.SIGTERM)
        assert child.wait(DEADLINE) == 0
        child.stdout.close()


@pytest.mark.process
def test_router_connects_two_clients_and_ends_on_a_signal() -> None:
    address = endpoint()
    heard: list[bytes] = []
    arrived = threading.Event()

    def keep(sample: zenoh.Sample) -> None:
        heard.append(sample.payload.to_bytes())
        arrived.set()

    with router(address):
        one = link.open_session(link.Link(connect=(address,)), threading.Event(), timeout=DEADLINE)
        other = link.open_session(link.Link(connect=(address,)), threading.Event(), timeout=DEADLINE)
        assert one is not None
        assert other is not None
        with one, other, one.declare_subscriber("a/b", keep), other.declare_publisher("a/b") as publisher:
            for _ in range(int(DEADLINE / 0.2)):  # until the subscription has come round
                publisher.put(b"hello")
                if arrived.wait(0.2):
                    break
    assert heard[0] == b"hello"


def test_zenoh_accepts_the_printed_configuration(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--listen", "tcp/0.0.0.0:7000", "--print"]) == 0
    text = capsys.readouterr().out
    assert json.loads(text)["mode"] == "router"
    assert json.loads(zenoh.Config.from_json5(text).get_json("listen/endpoints")) == ["tcp/0.0.0.0:7000"]


def test_denials_are_of_a_lab_only(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--no-denials"]) == 2
    assert capsys.readouterr().err == "iw-router: --no-denials: expected --lab too, got none\n"


@pytest.mark.process
def test_port_in_use_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        address = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        assert main(["--listen", address]) == 1
    assert f"iw-router: cannot listen at {address}: the port is in use" in capsys.readouterr().err


@pytest.mark.process
def test_world_with_a_router_alone_has_no_simulator_or_agent() -> None:
    address = endpoint()
    with router(address):
        assert present(["--router", "--connect", address]) == 0
        assert present(["--connect", address]) == 1


@pytest.mark.process
def test_router_begins_again_when_the_last_day_of_an_identity_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    last = datetime.date(2090, 1, 1)
    guest = Identity(name="guest", until=last.isoformat(), may=(May(role="viewer"),))
    ended = Identity(name="ended", until="2020-01-01", may=(May(role="viewer"),))
    file = tmp_path / "lab.xml"
    file.write_text(write_file(Lab(format="iw.v1", name="lab", identity=(guest, ended))))
    assert lab_keys.main(["keys", "--lab", str(file)]) == 0
    days = iter([last, last, last])
    replaced: list[list[str]] = []
    monkeypatch.setattr(command, "_today", lambda: next(days, last + datetime.timedelta(days=1)))
    monkeypatch.setattr(command, "stop_on_signals", lambda _lifeline: threading.Event())
    monkeypatch.setattr(os, "execv", lambda _program, words: replaced.append(words))
    assert main(["--lab", str(file), "--listen", endpoint(), "--no-denials"]) == 0
    assert next(days, None) is None, "not before its last day is over"
    assert replaced == [sys.orig_argv]
    assert "iw-router: restarted why='the last day of guest is over'" in capfd.readouterr().err


def test_router_that_is_replaced_again_and_again_waits_longer_each_time(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    pauses = [0.0]
    for _ in range(6):
        pauses.append(next_pause(pauses[-1], lived=1.0))
    assert pauses == [0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 10.0]
    assert next_pause(10.0, lived=3600.0) == 0.0
    # A wait ends with the process, before it listens.
    stopped = threading.Event()
    stopped.set()
    monkeypatch.setattr(command, "stop_on_signals", lambda _lifeline: stopped)
    monkeypatch.setenv("IW_ROUTER_PAUSE", "4.0")
    assert main([]) == 0
    assert "IW_ROUTER_PAUSE" not in os.environ
    assert "waiting seconds=4 why='restarted before'" in capfd.readouterr().err


@pytest.mark.process
def test_router_of_a_lab_that_begins_again_reports_denials_as_before(tmp_path: Path) -> None:
    address, file, log = endpoint(), tmp_path / "lab.xml", tmp_path / "log"
    student = Identity(name="student1", may=(May(role="agent", agents=("st1-*",)),))
    file.write_text(write_file(Lab(format="iw.v1", name="lab", identity=(student,))))
    assert lab_keys.main(["invite", "student1", "--lab", str(file), "--out", str(tmp_path / "own.iwid")]) == 0
    with log.open("w") as errors, router(address, "--lab", str(file), stderr=errors) as child:
        # What Zenoh would print.
        Path(f"/proc/{child.pid}/fd/2").write_text(
            "thread 'rx-1' (1) panicked at zenoh-transport/src/pipeline.rs:1:1\n"
        )
        assert child.stdout is not None
        assert child.stdout.readline() == f"ready listen={address}\n"
        route = link.Link(connect=(address,), identity=tmp_path / "own.iwid")
        session = link.open_session(route, threading.Event(), timeout=DEADLINE)
        assert session is not None
        with session:
            session.put("iw/v1/main/in/st2-a/actions", b"{}")
            with pytest.raises(ConnectionError, match="student1 may not ask for ctl/pause in world main"):
                link.query(session, "iw/v1/main/ctl/pause", b"{}", timeout=0.5)
    # The reader ends with the router, and writes the last lines first.
    said = log.read_text()
    assert "restarted why=" in said
    assert "denied why='student1 may not write in/st2-a/actions in world main' times=1" in said
    assert "denied why='student1 may not ask for ctl/pause in world main' times=1" in said


@pytest.mark.process
def test_connections_that_say_nothing_keep_nobody_out() -> None:
    address = endpoint()
    port = int(address.rpartition(":")[2])
    with router(address), ExitStack() as stack:
        for _ in range(200):
            stack.enter_context(socket.create_connection(("127.0.0.1", port), DEADLINE))
        # One attempt, which takes less time than such a connection may.
        session = link.open_session(link.Link(connect=(address,)), threading.Event(), timeout=0.0)
        assert session is not None
        session.close()  # type: ignore[no-untyped-call]


@pytest.mark.process
def test_sessions_beyond_the_number_are_closed_and_told_of(tmp_path: Path) -> None:
    address, log = endpoint(), tmp_path / "log"
    with log.open("w") as file, router(address, "--max-sessions", "2", stderr=file), ExitStack() as stack:

        def session() -> zenoh.Session:
            found = link.open_session(link.Link(connect=(address,)), threading.Event(), timeout=DEADLINE)
            assert found is not None
            return stack.enter_context(found)

        def echo(query: zenoh.Query) -> None:
            with query:
                query.reply("a/b", b"")

        first, second, third = session(), session(), session()
        first.declare_queryable("a/b", echo)
        ended = threading.Event()

        def on_link(event: zenoh.LinkEvent) -> None:
            if event.kind == zenoh.SampleKind.DELETE:
                ended.set()

        listener: Any = third.info.declare_link_events_listener(on_link)
        # It connects again and again; each time it is closed.
        assert ended.wait(DEADLINE)
        assert any(reply.ok is not None for reply in second.get("a/b", timeout=DEADLINE))
        listener.undeclare()
    assert "iw-router: closed session of=127.0.0.1 why='it has 2 already' closed=1\n" in log.read_text()


ROUTER_OF_A_FILE = """\
import sys, zenoh
with zenoh.open(zenoh.Config.from_file(sys.argv[1])):
    sys.stdin.read()
"""


@pytest.mark.process
def test_router_that_knows_only_the_printed_file_enforces_the_lab(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`ZENOHD=PATH pytest -k printed_file` runs it with the official router."""
    address, file = endpoint(), tmp_path / "lab.xml"
    student = Identity(name="student1", may=(May(role="agent", agents=("st1-*",)),))
    lab = Lab(format="iw.v1", name="lab", identity=(Identity(name="sim", may=(May(role="simulator"),)), student))
    file.write_text(write_file(lab))
    assert lab_keys.main(["keys", "--lab", str(file)]) == 0
    for name in ("sim", "student1"):
        assert lab_keys.main(["invite", name, "--lab", str(file), "--out", str(tmp_path / f"{name}.iwid")]) == 0
    capsys.readouterr()
    assert main(["--lab", str(file), "--listen", address, "--print"]) == 0
    printed = tmp_path / "router.json5"
    printed.write_text(capsys.readouterr().out)
    official = os.environ.get("ZENOHD")
    command = [official, "-c"] if official else [sys.executable, "-c", ROUTER_OF_A_FILE]
    child = subprocess.Popen([*command, str(printed)], stdin=subprocess.PIPE, start_new_session=True)
    assert child.stdin is not None

    def opened(name: str) -> zenoh.Session:
        route = link.Link(connect=(address,), identity=tmp_path / f"{name}.iwid" if name else None)
        found = link.open_session(route, threading.Event(), timeout=DEADLINE if name else 0.0)
        assert found is not None
        return found

    heard: set[str] = set()
    arrived = threading.Event()

    def keep(sample: zenoh.Sample) -> None:
        heard.add(str(sample.key_expr))
        arrived.set()

    try:
        with opened("sim") as simulator, opened("student1") as session:
            simulator.declare_subscriber("iw/v1/main/**", keep)
            for _ in range(int(DEADLINE / 0.2)):  # until the subscription has come round
                for key in ("in/st2-a/actions", "out/st1-a/power", "in/st1-a/actions"):
                    session.put(f"iw/v1/main/{key}", b"{}")
                if arrived.wait(0.2):
                    break
            assert heard == {"iw/v1/main/in/st1-a/actions"}
            # It does not tell what an identity may do; then the identity file does.
            with pytest.raises(ConnectionError, match="student1 may not ask for ctl/pause in world main"):
                link.query(session, "iw/v1/main/ctl/pause", b"{}", timeout=0.5)
        with pytest.raises(ConnectionError, match="expects --identity FILE"):
            opened("")
    finally:
        child.stdin.close()
        os.killpg(child.pid, signal.SIGTERM)
        child.wait(DEADLINE)
