"""A link to a view and back, and what a made-up link may hold."""

from __future__ import annotations

import pytest

from intellwheels_viewer.page_link import PageLink, link_of, query_of


def test_a_view_is_the_same_after_a_link() -> None:
    link = PageLink("follow", "chair2", 240, (1.0, -2.5, 3.25), (4.0, 5.0, 0.0))
    query = query_of(link)
    assert query == "?camera=follow&agent=chair2&tick=240&eye=1.000,-2.500,3.250&to=4.000,5.000,0.000"
    assert link_of(query) == (link, [])
    assert link_of(query_of(PageLink())) == (PageLink(), [])


def test_other_parts_of_an_address_are_left_alone() -> None:
    assert link_of("?fixedDpr=1&agent=a") == (PageLink(agent="a"), [])


@pytest.mark.parametrize(
    ("query", "word"),
    [
        ("?camera=above", "camera: expected one of free, plan, follow, first, got 'above'"),
        ("?agent=<b>", "agent: expected the name of a body"),
        ("?tick=-4", "tick: expected a whole number, got '-4'"),
        ("?tick=\u0664", "tick: expected a whole number"),
        ("?eye=1,2&to=1,2,3", "eye: expected three numbers of metres, got '1,2'"),
        ("?eye=1,2,3&to=nan,0,0", "to: expected three numbers"),
        ("?eye=1,2,3&to=1e9,0,0", "to: expected three numbers"),
    ],
)
def test_what_cannot_be_used_is_left_out_and_named(query: str, word: str) -> None:
    link, wrong = link_of(query)
    assert link == PageLink()
    assert [word in each for each in wrong] == [True]


def test_a_camera_that_looks_at_itself_is_none() -> None:
    assert link_of("?eye=1,2,3&to=1,2,3")[0].eye is None
