"""One server of pages for a file of tests, and a page of it for each."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import pytest
import viser

from intellwheels_viewer.origin_guard import open_server
from tests.viewer.browser import opened
from tests.viewer.opened import Opened
from tests.viewer.wire import until


@pytest.fixture(scope="module")
def pages() -> Iterator[viser.ViserServer]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        made = open_server("127.0.0.1", 0)
        yield made
        made.stop()


@pytest.fixture
def here(pages: viser.ViserServer) -> Iterator[Opened]:
    with opened(pages.get_port()) as browser:
        made = Opened(pages, browser)
        yield made
        made.page.close()
        made.page.join(5.0)
    until(lambda: not pages.get_clients())
