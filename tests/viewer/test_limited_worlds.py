"""A message that somebody made by hand does no more than the page may do."""

from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Identity, May, Pause, Take, UserInput
from intellwheels_viewer.limited_worlds import LimitedWorlds
from intellwheels_viewer.page_rights import EVERYTHING, PageRights
from intellwheels_viewer.steering import Refusal
from tests.viewer.opened import Network

STUDENT = PageRights(holders=(Identity(name="student1", may=(May(role="viewer", agents=("st1-*",)),)),))


def test_what_a_page_may_do_is_passed_on() -> None:
    network = Network()
    page = LimitedWorlds(network, lambda: EVERYTHING)
    assert page.ask("pause", Pause()).code == "ok"
    page.put_user("chair1", UserInput(forward=1.0))
    page.choose("ward")
    page.note_speech("hello", None)
    assert (page.quiet, page.world) == (0.0, "main")
    assert ([verb for verb, _ in network.asked], network.puts[0][0]) == (["pause"], "chair1")
    assert (network.worlds, network.speech) == (["ward"], [("hello", None)])


def test_the_rest_ends_here() -> None:
    network = Network()
    page = LimitedWorlds(network, lambda: STUDENT)
    page.ask("take", Take(agent="st1-a"))
    with pytest.raises(Refusal, match="View only: student1 may not ask for ctl/take/st2-a in world main"):
        page.ask("take", Take(agent="st2-a"))
    page.put_user("st2-a", UserInput(forward=1.0))
    looker = LimitedWorlds(network, lambda: PageRights("guests may only look"))
    with pytest.raises(Refusal, match="View only: guests may only look"):
        looker.ask("take", Take(agent="st1-a"))
    looker.put_user("st1-a", UserInput(forward=1.0))
    looker.choose("ward")
    assert (len(network.asked), network.puts, network.worlds) == (1, [], [])
