"""The legend of the scene."""

from __future__ import annotations

from intellwheels_schemas.agent_colours import css
from intellwheels_viewer.drawings import real_badge, wedges
from intellwheels_viewer.palette import SELECTED
from intellwheels_viewer.panels.legend import legend_html


def test_every_mark_has_its_meaning() -> None:
    page = legend_html(wedges.legend(), real_badge.legend())
    assert all(
        word in page
        for word in ("selected", "wants to go", "not its path", "last 20 s", "contact", "real", "virtual", "failed")
    )
    assert css(SELECTED) in page
    assert "doorway" not in page, "a doorway has a frame"
