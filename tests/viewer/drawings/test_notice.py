"""An empty scene says why it is empty, and no longer than it is."""

from __future__ import annotations

import viser

from intellwheels_viewer.drawings.notice import Notice
from tests.viewer.drawings.cast import node


def test_words_are_there_while_there_is_something_to_say(scene: viser.SceneApi) -> None:
    notice = Notice(scene)
    notice.show("")
    assert "/notice" not in scene._handle_from_node_name
    notice.show("No router\nStart one.")
    label = node(scene, "/notice")
    assert (label.text, label.visible) == ("No router\nStart one.", True)
    notice.show("")
    assert not label.visible
    notice.show("No world")
    assert (label.text, label.visible) == ("No world", True)
    assert node(scene, "/notice") is label
