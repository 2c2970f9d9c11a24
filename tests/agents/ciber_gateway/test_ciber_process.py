"""One `iw-ciber` between a world of the test and a viewer."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from intellwheels_agents.ciber_gateway import ciber_options
from intellwheels_agents.ciber_gateway.ciber_process import CiberProcess
from intellwheels_agents.ciber_gateway.reception import Reception
from intellwheels_schemas import link
from intellwheels_schemas.codec import encode
from intellwheels_schemas.keys import Keys
from tests.agents.ciber_gateway.stand_in_clients import GRID, LAB, TIMEOUT, Viewer
from tests.e2e.stage import free_port
from tests.maps.importers.drawn_floors import read

pytestmark = pytest.mark.process


@contextmanager
def gateway(*words: str) -> Iterator[tuple[int, list[str]]]:
    """Serve a map and `ctl`, run a gateway, and give its port and the verbs that arrive."""
    keys, endpoint, verbs = Keys("drawn"), f"tcp/127.0.0.1:{free_port()}", list[str]()
    document = encode(read({"MyLab.xml": LAB, "MyGrid.xml": GRID}).map)
    stop, ready, ports = threading.Event(), threading.Event(), list[int]()
    given = ciber_options.parser().parse_args(["--port", "0", *words])
    hub = link.open_session(link.Link("drawn", listen=(endpoint,)), stop)
    assert hub is not None

    def answer(query: object) -> None:
        key = str(query.key_expr)  # type: ignore[attr-defined]
        if "/ctl/" in key:
            verbs.append(key.rpartition("/")[2])
        data = document if key == keys.map else b'{"Code":"ok","Run":"0123456789abcdef","Tick":0}'
        query.reply(key, data, encoding="application/json")  # type: ignore[attr-defined]

    class Watched(CiberProcess):
        def _receive(self, reception: Reception) -> None:
            ports.append(reception.port)
            ready.set()
            super()._receive(reception)

    process = Watched(given, link.Link("drawn", connect=(endpoint,)), {}, stop)
    with hub, hub.declare_queryable(f"{keys.prefix}**", answer):
        thread = threading.Thread(target=process.run)
        thread.start()
        try:
            assert ready.wait(TIMEOUT)
            # It listens to the world a moment after its port is open.
            for _ in range(round(TIMEOUT / 0.05)):
                for key in (keys.clock, keys.state(0), keys.map):
                    for data in (b"", b"{", b"\xff" * 100, b"[" * 10_000):
                        hub.put(key, data, encoding="application/json")
                if process._reports.total or stop.wait(0.05):
                    break
            yield ports[0], verbs
        finally:
            stop.set()
            thread.join(TIMEOUT)
    assert not thread.is_alive()


def test_it_fails_if_nobody_can_register_any_more(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_self: Reception, _stop: threading.Event) -> None:
        raise ValueError("broken")

    monkeypatch.setattr(Reception, "run", broken)
    # What pytest does with errors of threads is not of this test.
    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    codes: list[int] = []
    run = CiberProcess.run
    monkeypatch.setattr(CiberProcess, "run", lambda process: codes.append(run(process)))
    with gateway():
        pass
    assert codes == [1]


def test_viewers_control_the_world_if_they_may() -> None:
    with gateway("--control") as (port, verbs):
        viewer = Viewer(port)
        assert [viewer.read(), viewer.read()] == ["Lab", "Grid"]
        waiting = threading.Event()
        for word in (b"<Stop/>\0", b"<Start/>\0"):
            viewer.send(word)
        for _ in range(round(TIMEOUT / 0.05)):
            if len(verbs) == 2:
                break
            waiting.wait(0.05)
        viewer.close()
    assert verbs == ["pause", "resume"]


def test_and_else_do_not(capsys: pytest.CaptureFixture[str]) -> None:
    with gateway() as (port, verbs):
        viewer = Viewer(port)
        assert [viewer.read(), viewer.read()] == ["Lab", "Grid"]
        viewer.send(b"<Stop/>")
        viewer.send(b"<LabReq/>")
        assert viewer.read() == "Lab"
        viewer.close()
    assert verbs == []
    assert "message of the world" in capsys.readouterr().err
