"""Where a pointer is while something is being placed; a page's numbers are a stranger's."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator
from typing import Any

import pytest
import viser

from intellwheels_viewer.panels.callbacks import element_id
from intellwheels_viewer.pointer_hover import PointerHover
from tests.viewer.panels.panel import enter, gui


@pytest.fixture(scope="module")
def api() -> Iterator[viser.GuiApi]:
    with gui() as made:
        yield made


@pytest.fixture
def places() -> list[tuple[float, float]]:
    return []


@pytest.fixture
def hover(api: viser.GuiApi, places: list[tuple[float, float]]) -> PointerHover:
    return PointerHover(api, lambda right, up: places.append((right, up)))


def test_the_place_is_told_as_it_comes(hover: PointerHover, places: list[tuple[float, float]]) -> None:
    for place in ((0.25, -1.0), (0.5, 1.0)):
        enter(hover._field, place)
    assert places == [(0.25, -1.0), (0.5, 1.0)]


@pytest.mark.parametrize("place", [(math.nan, 0.0), (0.0, math.inf), (1.1, 0.0), (0.0, -7.0)])
def test_what_is_no_place_in_the_picture_is_not(
    hover: PointerHover, places: list[Any], place: tuple[float, float]
) -> None:
    enter(hover._field, place)
    assert places == []


def test_the_page_sends_only_while_somebody_listens(hover: PointerHover) -> None:
    assert hover._handler.content == ""
    hover.listen(True)
    script = html.unescape(hover._handler.content)
    assert "window.iwHover.on=true" in script
    assert f"uuid='{element_id(hover._field)}'" in script
    hover.listen(False)
    assert "window.iwHover.on=false" in html.unescape(hover._handler.content)


def test_the_handler_is_one_attribute_that_nothing_leaves(hover: PointerHover) -> None:
    hover.listen(True)
    inner = hover._handler.content.partition('onerror="')[2]
    assert inner.endswith('">')
    assert '"' not in inner[:-2]
    assert "<" not in inner[:-2]
