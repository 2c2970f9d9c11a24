from __future__ import annotations

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Robot
from intellwheels_server.service.crews import Crews
from intellwheels_server.service.roster import Member

A, B = "a" * 16, "b" * 16


def member(agent: str, crew: str = "c", instance: str = A, encoding: Encoding = Encoding.JSON) -> Member:
    return Member(agent, "both", instance, "1" * 16, encoding, Robot(length=1.0, width=1.0), crew=crew)


def test_crew_is_there_while_it_has_members() -> None:
    crews = Crews()
    assert crews.place("a1", member("a1")) is None
    assert crews.place("a2", member("a2")) is None
    assert list(crews.named["c"].names) == ["a1", "a2"]
    assert crews.of("a2") is crews.named["c"]
    assert crews.place("a1", None) is None
    assert list(crews.named["c"].names) == ["a2"]
    assert crews.place("a2", None) == "c"
    assert crews.named == {}
    assert crews.of("a2") is None


def test_agent_that_joins_by_itself_or_with_another_crew_is_in_the_first_one_no_more() -> None:
    crews = Crews()
    crews.place("a1", member("a1"))
    crews.place("a2", member("a2"))
    assert crews.place("a1", member("a1", crew="")) is None
    assert crews.place("a2", member("a2", crew="d")) == "c"
    assert list(crews.named) == ["d"]


def test_names_are_the_same_object_until_one_comes_or_goes() -> None:
    crews = Crews()
    crews.place("a1", member("a1"))
    crew = crews.named["c"]
    names = crew.names
    assert crew.names is names
    crews.place("a2", member("a2"))
    assert list(crew.names) == ["a1", "a2"]


def test_crew_is_present_while_a_member_of_its_process_is() -> None:
    crews = Crews()
    old = member("a1")
    crews.place("a1", old)
    crew = crews.named["c"]
    assert crew.is_present
    old.absent_since = 1.0
    assert not crew.is_present
    crews.place("a2", member("a2", instance=B, encoding=Encoding.XML))
    assert crew.is_present
    assert (crew.instance, crew.encoding) == (B, Encoding.XML)
    # What happens to the member of the old process does not give the crew back to it.
    crews.place("a1", old)
    assert crew.instance == B
