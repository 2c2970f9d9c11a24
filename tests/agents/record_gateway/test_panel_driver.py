"""Who is driven by a page. `tests/e2e/test_record.py` drives chairs."""

from __future__ import annotations

from types import SimpleNamespace

from intellwheels_agents.record_gateway.panel_driver import PanelDriver
from intellwheels_agents.record_gateway.publish_panel import PublishPanel
from intellwheels_schemas.keys import Keys


def test_what_a_page_publishes_for_nobody_is_told(capsys: object) -> None:
    panel, told = PublishPanel(0.5), list[str]()
    panel.on_client_advertise(SimpleNamespace(id=1), SimpleNamespace(id=1, topic="/user/nobody"))
    panel.on_message_data(SimpleNamespace(id=1), 1, b'{"Forward": 1}')
    PanelDriver(None, Keys("w"), panel, take=False, log=told.append).work({}, 0.0)
    assert told == ["ignored why=\"topic: expected /user/ and an agent that is here, got '/user/nobody'\""]
