"""From a page's messages to plain callables: in order, own writes left out, and a click in HTML made an event.

The one place that leans on viser's private names: the id of an element, and in the page `__viserMutable.sendMessage`
(see CONTRIBUTING.md). A page's values are a stranger's: whoever is called checks them.
"""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import TypeVar

import viser

Value = TypeVar("Value")


def clicked(button: viser.GuiButtonHandle, call: Callable[[], None]) -> None:
    """Call at each click. Asynchronous without waiting: the loop keeps the order of the page's messages."""

    async def press(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        call()

    button.on_click(press)


def updated(handle: viser.GuiInputHandle[Value], call: Callable[[Value], None]) -> None:
    """Call with each value that comes from a page; our own writes come back too and are not one."""

    async def update(event: viser.GuiEvent[viser.GuiInputHandle[Value]]) -> None:
        if event.client_id is not None:
            call(handle.value)

    handle.on_update(update)


def chosen(group: viser.GuiButtonGroupHandle, call: Callable[[str], None]) -> None:
    """Call with the word on the button that was pressed, when the group has such a button."""

    async def press(_: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        if group.value in group.options:
            call(group.value)

    group.on_click(press)


def disable(group: viser.GuiButtonGroupHandle, disabled: bool) -> None:
    """Disable a group of buttons or enable it.

    The page can, and a group may be made so; the handle's own setter refuses (viser 1.1.1).
    """
    props = group._impl.props
    if props.disabled != disabled:  # type: ignore[attr-defined]
        props.disabled = disabled  # type: ignore[attr-defined]
        group._queue_update("disabled", disabled)


def assign(handle: viser.GuiInputHandle[Value], value: Value) -> None:
    """Set a value; viser sends nothing for an equal one."""
    # viser's property has a setter that mypy does not find: another method stands between the two.
    handle.value = value  # type: ignore[misc]


def element_id(handle: viser.GuiInputHandle[Value]) -> str:
    """Return the id by which a page's message names an element."""
    return str(handle._impl.uuid)


class Pick:
    """Makes `data-agent` elements of HTML choose: a press sends their name to a hidden text field.

    Args:
        gui: Where the field is made, unseen.
        call: Gets the name, which may be any text.
    """

    def __init__(self, gui: viser.GuiApi, call: Callable[[str], None]) -> None:
        self._field = gui.add_text("picked", "", visible=False)
        self._call = call
        updated(self._field, self._picked)

    @property
    def attribute(self) -> str:
        """The handler, an attribute of an element around the `data-agent` elements.

        On pointer down: a table that is rewritten between down and up would lose a click.
        """
        script = (
            "const r=event.target.closest('[data-agent]');if(r&&event.button===0)"
            "window.__viserMutable.sendMessage({type:'GuiUpdateMessage',"
            f"uuid:'{element_id(self._field)}',updates:{{value:r.dataset.agent}}}})"
        )
        return f'onpointerdown="{html.escape(script)}"'

    def _picked(self, name: str) -> None:
        # Emptied, so that the same name is a change the next time.
        assign(self._field, "")
        if name:
            self._call(name)
