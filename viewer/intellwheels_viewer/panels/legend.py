"""The legend of the scene: what its marks mean, beside the colours of the sensors. Pure."""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.agent_colours import css
from intellwheels_viewer.palette import CONTACT, SELECTED
from intellwheels_viewer.panels.style_sheet import block

_MARKS: Final = (
    (
        '<circle cx="22" cy="11" r="8" fill="none" stroke="#4a4200" stroke-width="4.5"/>'
        f'<circle cx="22" cy="11" r="8" fill="none" stroke="{css(SELECTED)}" stroke-width="3"/>',
        "selected",
    ),
    (
        '<circle cx="34" cy="11" r="7" fill="none" stroke="currentColor" stroke-width="1.5"/>'
        '<circle cx="34" cy="11" r="2" fill="currentColor"/><path fill="none" '
        'd="M2 5l5 6l-5 6M9 7l3.5 4l-3.5 4M15 8.5l2 2.5l-2 2.5" stroke="currentColor" stroke-width="2"/>',
        "where an agent wants to go, in its colour; not its path",
    ),
    (
        '<path d="M2 16C14 16 18 6 42 6" fill="none" stroke="currentColor" stroke-width="3"/>',
        "where it was in the last 20 s",
    ),
    (f'<rect x="8" y="5" width="28" height="12" fill="none" stroke="{css(CONTACT)}" stroke-width="3"/>', "contact"),
)
"""A mark, 44 x 22 px, and its meaning."""


def legend_html(wedges: str, real: str = "") -> str:
    """Return the legend.

    Args:
        wedges: The rows of the sensors, as HTML.
        real: The rows of real and virtual chairs.
    """
    rows = "".join(
        f'<tr><td style="width:46px;padding:1px 8px 1px 0;border:0;text-align:left"><svg width="44" height="22" '
        f'viewBox="0 0 44 22" style="display:block" aria-hidden="true">{mark}</svg></td>'
        f'<td style="padding:1px 0;border:0;text-align:left">{words}</td></tr>'
        for mark, words in _MARKS
    )
    return block(
        "legend",
        '<div class="iw-caption iw-group">marks in the scene</div>',
        f"<table>{rows}</table>",
        '<div class="iw-caption iw-group">real and virtual chairs</div>' if real else "",
        real,
        '<div class="iw-caption iw-group">range of a proximity sensor</div>',
        wedges,
    )
