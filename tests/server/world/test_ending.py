import pytest

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import End, Place, Reach, Timeout
from intellwheels_server.world.ending import end_reason
from tests.server.worlds import cart, floor_of, world

FLOOR = floor_of((), (Place(name="here", x=0.3, y=0.4), Place(name="there", x=9.0, y=0.0)))


def reach(agent: str = "a", place: str = "here", within: float = 0.5) -> Reach:
    return Reach(agent=agent, place=place, within=within)


@pytest.mark.parametrize(
    ("end", "reason"),
    [
        (End(), None),
        (End(reach=(reach(),)), "reached"),
        (End(reach=(reach(within=0.49),)), None),
        (End(reach=(reach(), reach(place="there"))), None),
        (End(reach=(reach(), reach(agent="nobody"))), None),
        (End(timeout=Timeout(seconds=1.0)), None),
    ],
)
def test_end_is_met_when_every_reach_is(end: End, reason: str | None) -> None:
    assert end_reason(world({"a": cart()}, floor=FLOOR), end) == reason


def test_place_that_is_not_on_the_floor_is_refused() -> None:
    with pytest.raises(RequestRefusedError, match="no place 'moon'"):
        end_reason(world({"a": cart()}, floor=FLOOR), End(reach=(reach(place="moon"),)))
