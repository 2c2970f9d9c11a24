"""What pages publish becomes the input of users."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from intellwheels_agents.record_gateway.publish_panel import AGAIN, REPEAT_EVERY, PublishPanel, user_input
from intellwheels_maps import robot
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Robot, UserInput

CHAIR = robot("intellwheels")
ROBOTS = {"c": CHAIR}
PAGE = SimpleNamespace(id=1)


def panel(topic: str = "/user/c") -> PublishPanel:
    found = PublishPanel(0.5)
    found.on_client_advertise(PAGE, SimpleNamespace(id=7, topic=topic))
    return found


def test_an_input_is_repeated_for_its_time_and_then_a_zero_is_sent_once() -> None:
    pages = panel()
    pages.on_message_data(PAGE, 7, b'{"Forward": 0.5}')
    sent = []
    now = 10.0
    while now < 12.0:
        sent += [user.forward for _, user in pages.inputs(ROBOTS, now)[0]]
        now += REPEAT_EVERY
    assert sent in ([*([0.5] * 5), 0.0], [*([0.5] * 6), 0.0])


def test_a_twist_becomes_shares_of_the_top_speed() -> None:
    data = b'{"linear": {"x": %f}, "angular": {"z": %f}}' % (CHAIR.top_speed / 2, CHAIR.top_speed / CHAIR.track)
    user = user_input(data, CHAIR)
    assert (user.forward, user.turn) == pytest.approx((0.5, 0.5), abs=1e-5)
    assert user_input(b'{"linear": {"x": 99}, "angular": {"z": -99}}', CHAIR) == UserInput(forward=1.0, turn=-1.0)


@pytest.mark.parametrize("data", [b"", b"{", b"[]", b'{"Forward": 7}', b'{"Lease": "0123456789abcdef"}', b"[" * 9999])
def test_what_is_no_input_is_refused(data: bytes) -> None:
    with pytest.raises(WireError):
        user_input(data, CHAIR)
    with pytest.raises(WireError, match="a body with motors"):
        user_input(b'{"linear": {}, "angular": {}}', Robot())


@given(st.binary(max_size=100), st.text(max_size=50))
def test_no_page_raises(data: bytes, topic: str) -> None:
    pages = panel(topic)
    pages.on_message_data(PAGE, 7, data)
    pages.on_message_data(PAGE, 8, data)
    pages.on_client_unadvertise(PAGE, 7)
    found, wrong = pages.inputs(ROBOTS, 0.0)
    assert (found, len(wrong)) == ([], 1)


def test_topics_that_pages_subscribe_to_are_told_once_and_once_more_a_little_later() -> None:
    pages = panel()
    for _ in range(3):
        pages.on_subscribe(PAGE, SimpleNamespace(id=1, topic="/scene"))
    assert pages.subscribed(1.0) == ["/scene"]
    for after in AGAIN:
        assert pages.subscribed(1.0 + 0.9 * after) == []
        # The server may not have served the subscription before.
        assert pages.subscribed(1.0 + after) == ["/scene"]
    assert pages.subscribed(100.0) == []
