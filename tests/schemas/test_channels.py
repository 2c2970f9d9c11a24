from __future__ import annotations

from intellwheels_schemas.channels import CHANNELS, VERB_CLASSES
from intellwheels_schemas.keys import AGENT_VERBS, VERBS
from intellwheels_schemas.messages import Lab, Map, Scene
from intellwheels_schemas.vectors import NAMES


def test_every_document_but_the_scene_travels_somewhere() -> None:
    carried = {
        cls for channel in CHANNELS.values() for cls in (*channel.carries, *channel.replies, *channel.errors)
    }  # fmt: skip
    assert carried == set(NAMES.values()) - {Scene, Lab}
    assert Map in carried


def test_every_verb_has_its_class() -> None:
    assert VERB_CLASSES.keys() == VERBS.keys()
    assert set(VERB_CLASSES.values()) == set(CHANNELS["ctl"].carries) | set(CHANNELS["ctl_agent"].carries)
    assert {verb for verb, cls in VERB_CLASSES.items() if cls in CHANNELS["ctl_agent"].carries} == AGENT_VERBS


def test_only_the_clock_is_express() -> None:
    assert [name for name, channel in CHANNELS.items() if channel.express] == ["clock"]
