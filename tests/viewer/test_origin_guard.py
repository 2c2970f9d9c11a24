"""Who may talk to the page: attacks on a server that runs, and those who are welcome."""

from __future__ import annotations

import http.client
import socket
import threading
from collections.abc import Iterator, Mapping

import pytest
import viser
from websockets.exceptions import InvalidStatus

from intellwheels_viewer.origin_guard import MAX_MESSAGE, admit, check_free, open_server
from tests.viewer.browser import dial, opened
from tests.viewer.wire import until

# viser's own use of websockets
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        made = open_server("127.0.0.1", 0, frozenset({"Lab-PC"}))
        yield made
        made.stop()


def answer(port: int, request: str) -> str:
    """Send raw bytes and return the first line of the answer, and the rest."""
    with socket.create_connection(("127.0.0.1", port), timeout=10.0) as peer:
        peer.sendall(request.encode())
        data = b""
        while more := peer.recv(65536):
            data += more
            if len(data) > 4000:
                break
    return data.decode("latin-1")


def shake(host: str, *more: str) -> str:
    lines = [
        "GET / HTTP/1.1", *([f"Host: {host}"] if host else []), "Upgrade: websocket", "Connection: Upgrade",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Version: 13", *more, "", "",
    ]  # fmt: skip
    return "\r\n".join(lines)


# ---------------------------------------------------------------- attacks


@pytest.mark.process
def test_a_foreign_page_is_refused_before_a_word(server: viser.ViserServer) -> None:
    with pytest.raises(InvalidStatus) as refused:
        dial(server.get_port(), origin="https://evil.example")
    assert refused.value.response.status_code == 403


@pytest.mark.process
@pytest.mark.parametrize("host", ["evil.example", "rebound.evil.example:8080", "", "localhost.evil.example"])
def test_a_name_that_was_bent_to_us_is_refused(server: viser.ViserServer, host: str) -> None:
    said = answer(server.get_port(), shake(host))
    assert said.startswith("HTTP/1.1 4")
    assert "101" not in said.splitlines()[0]


@pytest.mark.process
def test_two_hosts_are_refused(server: viser.ViserServer) -> None:
    port = server.get_port()
    said = answer(port, shake(f"localhost:{port}", "Host: evil.example"))
    assert said.startswith("HTTP/1.1 403")
    said = answer(port, shake("evil.example", f"Host: localhost:{port}"))
    assert said.startswith("HTTP/1.1 403")


@pytest.mark.process
def test_two_origins_are_refused(server: viser.ViserServer) -> None:
    port = server.get_port()
    ours = f"localhost:{port}"
    said = answer(port, shake(ours, f"Origin: http://{ours}", "Origin: http://evil.example"))
    assert said.startswith("HTTP/1.1 403")


@pytest.mark.process
def test_an_origin_that_is_no_address_is_refused_in_words(server: viser.ViserServer) -> None:
    port = server.get_port()
    said = answer(port, shake(f"localhost:{port}", "Origin: http://["))
    assert said.startswith("HTTP/1.1 403")
    assert "Origin: expected" in said


@pytest.mark.process
def test_files_of_the_page_are_guarded_too(server: viser.ViserServer) -> None:
    port = server.get_port()
    said = answer(port, "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n")
    assert said.startswith("HTTP/1.1 403")
    assert "see --allow-host" in said
    assert "<html" not in said


@pytest.mark.process
def test_no_message_publishes_the_viewer(server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
    called = threading.Event()
    monkeypatch.setattr(server, "request_share_url", lambda *_, **__: called.set())
    monkeypatch.setattr(server, "disconnect_share_url", lambda *_, **__: called.set())
    reached = threading.Event()
    server.on_client_connect(lambda _: reached.set())
    with opened(server.get_port(), looks=False) as browser:
        browser.send({"type": "ShareUrlRequest"})
        browser.send({"type": "ShareUrlDisconnect"})
        browser.look()  # messages are taken in order: this one comes after those
        assert reached.wait(10.0)
    assert not called.is_set()
    assert server._share_tunnel is None


@pytest.mark.process
def test_no_file_is_taken_from_a_stranger(server: viser.ViserServer) -> None:
    visits: list[Mapping[str, str]] = []
    box: list[viser.GuiTextHandle] = []

    def connected(client: viser.ClientHandle) -> None:
        visits.append(admit(client, server))
        box.append(client.gui.add_text("Box", ""))

    server.on_client_connect(connected)
    port = server.get_port()
    with opened(port, looks=False) as browser:
        browser.look()
        element = browser.element("Box")
        upload = {"source_component_uuid": element, "transfer_uuid": "a"}
        start = {"filename": "f", "mime_type": "x", "part_count": 2, "size_bytes": 2000}
        browser.send({"type": "FileTransferStartUpload", **start, **upload})
        browser.send({"type": "FileTransferPart", "part_index": 0, "content": b"x" * 1000, **upload})
        browser.enter("Box", "after")  # messages are taken in order
        until(lambda: box[0].value == "after")
        for gui in (server.gui, next(iter(server.get_clients().values())).gui):
            assert gui._current_file_upload_states == {}
        assert visits[0]["host"] == f"127.0.0.1:{port}"
        browser.connection.send(bytes(MAX_MESSAGE + 1))
        browser.wait(lambda: browser.connection.close_code is not None or None)
        assert browser.connection.close_code == 1009


# ---------------------------------------------------------------- the welcome


@pytest.mark.process
@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "[::1]", "lab-pc"])
def test_our_page_is_served_under_all_our_names(server: viser.ViserServer, host: str) -> None:
    client = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=10.0)
    client.request("GET", "/", headers={"Host": f"{host}:{server.get_port()}"})
    response = client.getresponse()
    assert response.status == 200
    assert b"<html" in response.read()
    client.close()


@pytest.mark.process
def test_our_page_and_a_plain_client_connect(server: viser.ViserServer) -> None:
    port = server.get_port()
    for origin in (None, f"http://127.0.0.1:{port}"):
        with dial(port, origin=origin) as connection:
            assert isinstance(connection.recv(timeout=10.0), bytes)


# ---------------------------------------------------------------- the port


def test_a_port_that_is_taken_is_told_in_words() -> None:
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        port = holder.getsockname()[1]
        with pytest.raises(ConnectionError, match=rf"127.0.0.1:{port}: the port is in use.*--port"):
            open_server("127.0.0.1", port)


def test_an_address_that_is_none_of_ours_is_told_in_words() -> None:
    with pytest.raises(ConnectionError, match=r"cannot serve the page at 192\.0\.2\.1:8080"):
        check_free("192.0.2.1", 8080)
    with pytest.raises(ConnectionError, match="cannot serve the page"):
        check_free("no.such.host.invalid", 8080)


def test_a_free_port_is_found_without_asking() -> None:
    check_free("127.0.0.1", 0)


def test_the_port_that_was_asked_for_is_the_one_that_is_served() -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    made = open_server("127.0.0.1", port)
    try:
        assert made.get_port() == port
    finally:
        made.stop()
