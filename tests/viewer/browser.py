"""A browser without a window: viser's own protocol over a raw websocket.

It keeps what it is told, and sends anything.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

import msgspec
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

DEADLINE: Final = 20.0
CAMERA: Final = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (3.0, 3.0, 3.0), "fov": 0.8, "near": 0.1,
    "far": 1000.0, "image_height": 800, "image_width": 1280, "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip


class Browser:
    """A page that is open.

    Attributes:
        received: Bytes that came.
        heard: All messages but those of drawing, in order.
        gui: The elements of the page by id, as they are now, with their `type`.
        scene: The names of the nodes.
    """

    def __init__(self, connection: ClientConnection, *, reads: bool = True, storage: str | None = "none") -> None:
        self.connection = connection
        self.received = 0
        self.heard: list[dict[str, Any]] = []
        self.gui: dict[str, dict[str, Any]] = {}
        self.scene: set[str] = set()
        self._storage = storage
        self._news = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        if reads:
            self._reader.start()

    def send(self, message: dict[str, Any]) -> None:
        """Send what a page would, or would not."""
        self.connection.send(msgspec.msgpack.encode(message))

    def look(self, **changes: Any) -> None:
        """Say where the camera is; with the first such word the page is there."""
        self.send({**CAMERA, **changes})

    def element(self, label: str) -> str:
        """Wait for an element with this label and return its id."""

        def found() -> str | None:
            for uuid, props in self.gui.items():
                if props.get("label") == label:
                    return uuid
            return None

        return str(self.wait(found))

    def enter(self, label: str, value: Any) -> None:
        """Give an element a value, as a page does when somebody types or presses."""
        self.send({"type": "GuiUpdateMessage", "uuid": self.element(label), "updates": {"value": value}})

    def text(self) -> str:
        """Return all HTML of the page."""
        return "\n".join(str(props.get("content", "")) for props in list(self.gui.values()))

    def wait(self, there: Callable[[], Any], seconds: float = DEADLINE) -> Any:
        """Wait until something is so, looked at with each message."""
        with self._news:
            found = self._news.wait_for(there, seconds)
        assert found, "it did not come"
        return found

    def _read(self) -> None:
        try:
            for data in self.connection:
                assert isinstance(data, bytes)
                with self._news:
                    self.received += len(data)
                    for message in unpacked(data):
                        self._take(message)
                    self._news.notify_all()
        except ConnectionClosed:
            pass
        finally:
            with self._news:  # whoever waits for the end of the connection need not wait for its deadline
                self._news.notify_all()

    def _take(self, message: dict[str, Any]) -> None:
        kind = message["type"]
        if kind == "LocalStorageGetItemRequestMessage" and self._storage is not None:
            blocked = self._storage == "blocked"
            self.send(
                {
                    "type": "LocalStorageGetItemResponseMessage",
                    "value": None if self._storage in ("none", "blocked") else self._storage,
                    "error": "blocked by the browser" if blocked else None,
                    "request_uuid": message["request_uuid"],
                }
            )
        if kind == "GuiUpdateMessage":
            self.gui.setdefault(message["uuid"], {}).update(message["updates"])
        elif kind.startswith("Gui") and "uuid" in message:
            self.gui[message["uuid"]] = {"type": kind, **(message.get("props") or {})}
        elif kind.startswith("SceneNode"):
            pass
        elif "props" in message and "name" in message:
            self.scene.add(message["name"])
        else:
            self.heard.append(message)


def unpacked(data: bytes) -> list[dict[str, Any]]:
    """Return the messages of a packet; arrays are left as what stands for them."""
    size, packed = struct.unpack_from("<QQ", data)
    inner = zstandard.ZstdDecompressor().decompress(data[16 : 16 + packed], max_output_size=size)
    return list(msgspec.msgpack.decode(inner)["messages"])


def dial(port: int, *, origin: str | None = None, **named: Any) -> ClientConnection:
    """Connect as viser's page does, or not at all."""
    return connect(
        f"ws://127.0.0.1:{port}",
        origin=None if origin is None else Origin(origin),
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        max_size=None,
        open_timeout=DEADLINE,
        close_timeout=2.0,
        compression=None,
        **named,
    )


@contextmanager
def opened(
    port: int, *, reads: bool = True, storage: str | None = "none", looks: bool = True, origin: str | None = None
) -> Iterator[Browser]:
    """Open the page, and close it."""
    connection = dial(port, origin=origin)
    with connection:
        browser = Browser(connection, reads=reads, storage=storage)
        if looks:
            browser.look()
        yield browser
