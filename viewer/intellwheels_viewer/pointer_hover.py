"""The position of a browser's pointer over the scene, while something is being placed.

Viser reports only clicks and drags, so a script in the page sends the pointer's position, at most ten times a second
and only while it is switched on. It uses the same private names of viser as `panels.callbacks`.
"""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_viewer.panels.callbacks import element_id, updated

_SCRIPT: Final = """
if(!window.iwHover){window.iwHover={on:false,last:0};
window.addEventListener('pointermove',e=>{const h=window.iwHover,m=window.__viserMutable,c=m&&m.canvas;
if(!h.on||!c||e.target!==c||e.buttons||e.timeStamp-h.last<100)return;h.last=e.timeStamp;
const r=c.getBoundingClientRect();
m.sendMessage({type:'GuiUpdateMessage',uuid:h.uuid,
updates:{value:[2*(e.clientX-r.left)/r.width-1,1-2*(e.clientY-r.top)/r.height]}});});}
window.iwHover.uuid='%UUID%';window.iwHover.on=%ON%;
"""


class PointerHover:
    """The pointer of one browser.

    Args:
        gui: The browser's elements.
        call: Called with the position, right and up from the centre of the picture, each in [-1, 1].
    """

    def __init__(self, gui: viser.GuiApi, call: Callable[[float, float], None]) -> None:
        self._call = call
        self._field = gui.add_vector2("pointer", (0.0, 0.0), visible=False)
        self._handler = gui.add_html("")
        updated(self._field, self._moved)

    def listen(self, on: bool) -> None:
        """Switch it on or off."""
        script = _SCRIPT.replace("%UUID%", element_id(self._field)).replace("%ON%", "true" if on else "false")
        self._handler.content = f'<img src="x:" alt="" style="display:none" onerror="{html.escape(script)}">'

    def _moved(self, place: tuple[float, float]) -> None:
        right, up = place
        # The values of a page are not trusted.
        if math.isfinite(right) and math.isfinite(up) and max(abs(right), abs(up)) <= 1.0:
            self._call(right, up)
