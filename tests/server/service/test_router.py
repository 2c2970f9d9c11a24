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

import pytest
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Identity, Lab, May
from intellwheels_schemas.present import main as present
from intellwheels_server.service import lab_keys
from intellwheels_server.service import router as command
from intellwheels_server.service.router import main

DEADLINE = 30.0


def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@contextmanager
def router(address: str) -> Iterator["subprocess.Popen[str]"]:
    child = subprocess.Popen(
        [sys.executable, "-m", "intellwheels_server.service.router", "--listen", address],
        stdout=subprocess.PIPE,
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
    assert main(["--lab", str(file), "--listen", endpoint()]) == 0
    assert next(days, None) is None, "not before its last day is over"
    assert replaced == [sys.orig_argv]
    assert "iw-router: restarted why='the last day of guest is over'" in capfd.readouterr().err


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
