"""The legend of the scene."""

from __future__ import annotations

from intellwheels_schemas.agent_colours import css
from intellwheels_viewer.drawings import wedges
from intellwheels_viewer.palette import DOORWAY
from intellwheels_viewer.panels.legend import legend_html


def test_every_mark_has_its_meaning() -> None:
    page = legend_html(wedges.legend())
    assert all(word in page for word in ("selected", "goal", "path", "contact", "doorway", "failed"))
    assert css(DOORWAY) in page
