"""A panel's elements without a page: a server's, and messages as a page would send them."""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import viser


@contextmanager
def gui() -> Iterator[viser.GuiApi]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # viser's own use of websockets
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        yield server.gui
    finally:
        server.stop()


def press(handle: Any) -> None:
    """What a page's click calls."""
    for call in handle._impl.update_cb:
        asyncio.run(call(viser.GuiEvent(cast("Any", None), 1, handle)))


def enter(handle: Any, value: Any) -> None:
    """What a page's new value calls; viser has then set it already."""
    handle._impl.value = value
    press(handle)


def hold(handle: Any) -> None:
    """What a page's held button calls."""
    for calls in handle._button_impl.hold_cbs_from_freq.values():
        for call in calls:
            asyncio.run(call(viser.GuiEvent(cast("Any", None), 1, handle)))


class Calls(list[tuple[Any, ...]]):
    """What a panel called: a name and its arguments each."""

    def to(self, name: str) -> Any:
        return lambda *arguments: self.append((name, *arguments))
