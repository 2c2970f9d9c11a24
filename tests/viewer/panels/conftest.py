"""One viser server for the panels' tests: elements are many, ports are few."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest
import viser

from tests.viewer.panels import board, panel


@pytest.fixture(scope="session")
def gui() -> Iterator[viser.GuiApi]:
    with panel.gui() as api:
        yield api


@pytest.fixture
def calls() -> panel.Calls:
    return panel.Calls()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """A module's: while Playwright runs, no other event loop does in this thread."""
    if board.CHROMIUM is None:
        words = "no Chromium: the panels' page is not tested"
        if os.environ.get("REQUIRE_BROWSER") == "1":
            pytest.fail(words)
        pytest.skip(words)
    with board.browser() as one:
        yield one
