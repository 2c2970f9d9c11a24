"""Turns a page's messages into calls, in order and without echoes of our own writes, and HTML clicks into events.

It uses private names of viser: the id of an element and, in the page, `__viserMutable.sendMessage` (see
CONTRIBUTING.md). The values of a page are not trusted: the called function checks them.
"""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import TypeVar

import viser

Value = TypeVar("Value")


def clicked(button: viser.GuiButtonHandle, call: Callable[[], None]) -> None:
    """Call at each click. The callback is a coroutine that does not wait, so the order of the messages is kept."""

    async def press(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        call()

    button.on_click(press)


def updated(handle: viser.GuiInputHandle[Value], call: Callable[[Value], None]) -> None:
    """Call with each value that a page sends. Echoes of our own writes are left out."""

    async def update(event: viser.GuiEvent[viser.GuiInputHandle[Value]]) -> None:
        if event.client_id is not None:
            call(handle.value)

    handle.on_update(update)


def chosen(group: viser.GuiButtonGroupHandle, call: Callable[[str], None]) -> None:
    """Call with the text of the pressed button, if the group has such a button."""

    async def press(_: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        if group.value in group.options:
            call(group.value)

    group.on_click(press)


def disable(group: viser.GuiButtonGroupHandle, disabled: bool) -> None:
    """Disable or enable a group of buttons.

    A group can be created disabled and the page supports it, but the handle's setter refuses (viser 1.1.1).
    """
    props = group._impl.props
    if props.disabled != disabled:  # type: ignore[attr-defined]
        props.disabled = disabled  # type: ignore[attr-defined]
        group._queue_update("disabled", disabled)


def assign(handle: viser.GuiInputHandle[Value], value: Value) -> None:
    """Set a value. Viser sends nothing for an equal one."""
    # viser's property has a setter that mypy does not find: another method stands between the two.
    handle.value = value  # type: ignore[misc]


def element_id(handle: viser.GuiInputHandle[Value]) -> str:
    """Return the id of an element in a page's messages."""
    return str(handle._impl.uuid)


class Pick:
    """Makes elements in HTML clickable: a press sends the text of their data attribute to a hidden text field.

    Args:
        gui: Makes the hidden field.
        call: Called with the text, which can be any.
        data: The name of the attribute, without `data-`. Elements with `data-agent` act when the pointer goes down,
            all others, which must be buttons, when they are clicked or pressed with a key.
    """

    def __init__(self, gui: viser.GuiApi, call: Callable[[str], None], data: str = "agent") -> None:
        self._field = gui.add_text("picked", "", visible=False)
        self._call, self._data = call, data
        updated(self._field, self._picked)

    @property
    def attribute(self) -> str:
        """The HTML attribute for an element around these elements.

        A table reacts to pointer down, because one that is rewritten between down and up would lose a click. With keys
        an agent is selected from the list or by its digit: a row that is rewritten would lose the focus too.
        """
        send = (
            "window.__viserMutable.sendMessage({type:'GuiUpdateMessage',"
            f"uuid:'{element_id(self._field)}',updates:{{value:r.dataset.{self._data}}}}})"
        )
        found = f"const r=event.target.closest('[data-{self._data}]');"
        if self._data != "agent":
            return f'onclick="{html.escape(f"{found}if(r&&!r.disabled){send}")}"'
        return f'onpointerdown="{html.escape(f"{found}if(r&&event.button===0){send}")}"'

    def _picked(self, name: str) -> None:
        # Emptied, so that the same name is a change next time.
        assign(self._field, "")
        if name:
            self._call(name)
