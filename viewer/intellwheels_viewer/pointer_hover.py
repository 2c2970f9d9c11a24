"""Where a browser's pointer is over the scene, while something is being placed.

Viser tells of clicks and drags only, so the page's own handler sends the pointer's place, ten times a second at most,
and only while somebody listens. It leans on the same private names as `panels.callbacks`.
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
        gui: The browser's own.
        call: Gets the place, from the middle of the picture to the right and up, each in [-1, 1].
    """

    def __init__(self, gui: viser.GuiApi, call: Callable[[float, float], None]) -> None:
        self._call = call
        self._field = gui.add_vector2("pointer", (0.0, 0.0), visible=False)
        self._handler = gui.add_html("")
        updated(self._field, self._moved)

    def listen(self, on: bool) -> None:
        """Begin to be told, or end it."""
        script = _SCRIPT.replace("%UUID%", element_id(self._field)).replace("%ON%", "true" if on else "false")
        self._handler.content = f'<img src="x:" alt="" style="display:none" onerror="{html.escape(script)}">'

    def _moved(self, place: tuple[float, float]) -> None:
        right, up = place
        # A page's values are a stranger's.
        if math.isfinite(right) and math.isfinite(up) and max(abs(right), abs(up)) <= 1.0:
            self._call(right, up)
