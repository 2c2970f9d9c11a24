"""The title of the browser tab."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest

from intellwheels_viewer.page_title import reality, script, title_of
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.panels import made_up
from tests.viewer.wire import body

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_a_title_names_the_floor_and_the_world() -> None:
    floor = made_up.snapshot().floor
    assert floor is not None
    assert title_of(made_up.snapshot()) == f"{floor.title} \u2013 1 real, 6 virtual \u2013 main \u2013 IntellWheels"
    assert title_of(SNAPSHOT).endswith("IntellWheels")
    assert title_of(replace(made_up.snapshot(), floor=msgspec.structs.replace(floor, title=None))).startswith(
        floor.name
    )
    assert title_of(made_up.nothing("no-world")) == "IntellWheels"


def test_it_says_what_is_real_and_nothing_where_nothing_is() -> None:
    bodies = {name: body(name) for name in ("a", "b")}
    assert reality(replace(SNAPSHOT, bodies=bodies)) == []
    real = msgspec.structs.replace(bodies["a"].robot, type="real", hardware="simulated")
    bodies["a"] = msgspec.structs.replace(bodies["a"], robot=real)
    assert reality(replace(SNAPSHOT, bodies=bodies)) == ["1 stand-in for a real chair, 1 virtual"]
    bodies["b"] = msgspec.structs.replace(bodies["b"], robot=msgspec.structs.replace(bodies["b"].robot, type="real"))
    assert reality(replace(SNAPSHOT, bodies=bodies)) == ["1 real, 1 stand-in for a real chair"]
    bodies["b"] = bodies["a"]
    assert reality(replace(SNAPSHOT, bodies=bodies)) == ["2 stand-ins for real chairs"]


def test_the_title_of_a_peer_is_text() -> None:
    page = script("\"</script><img src=x: onerror=alert(1)>\u2028'")
    assert page.count("<") == 1
    assert "&quot;\\&quot;&lt;/script&gt;&lt;img" in page


def test_the_page_sets_its_title(here: Opened) -> None:
    here.show(SNAPSHOT)
    here.browser.wait(lambda: "document.title=" in here.browser.text() and "IntellWheels" in here.browser.text())
