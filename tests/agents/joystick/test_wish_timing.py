"""When a wish is put: at once when it changes, 20 times a second while held, zeros and then nothing when let go."""

from __future__ import annotations

from intellwheels_agents.joystick.wish import NOTHING, Wish
from intellwheels_agents.joystick.wish_timing import WishTiming
from intellwheels_schemas.messages import UserInput

AHEAD = Wish(forward=0.5, buttons=(1,), word="go")


def puts(hand: WishTiming, wish: Wish, begin: float, end: float) -> list[UserInput]:
    """Return what is put by a loop of 100 turns a second."""
    found = [hand.put(wish, begin + 0.01 * k) for k in range(round((end - begin) / 0.01))]
    return [user for user in found if user is not None]


def test_a_held_wish_is_put_twenty_times_a_second() -> None:
    users = puts(WishTiming(), AHEAD, 0.0, 2.0)
    assert 20 <= len(users) <= 40
    assert {(user.forward, user.buttons, user.word, user.lease) for user in users} == {(0.5, (1,), "go", None)}
    assert [user.seq for user in users] == list(range(1, len(users) + 1))


def test_a_hand_that_rests_puts_nothing() -> None:
    assert puts(WishTiming(), NOTHING, 0.0, 1.0) == []


def test_letting_go_is_put_at_once_and_three_times_and_then_there_is_silence() -> None:
    hand = WishTiming()
    puts(hand, AHEAD, 0.0, 1.0)
    first = hand.put(NOTHING, 1.001)
    assert first is not None
    assert (first.forward, first.buttons, first.word) == (0.0, (), None)
    assert len(puts(hand, NOTHING, 1.01, 3.0)) == 2


def test_another_wish_does_not_wait_but_a_trembling_one_is_held_back() -> None:
    hand = WishTiming()
    assert hand.put(Wish(0.5), 1.0) is not None
    assert hand.put(Wish(0.6), 1.001) is None
    assert hand.put(Wish(0.6), 1.021) is not None
    assert hand.put(Wish(0.6), 1.042) is None


def test_a_hand_that_goes_puts_a_last_zero_unless_it_rested() -> None:
    hand = WishTiming()
    assert hand.off(0.0) is None
    hand.put(AHEAD, 1.0)
    last = hand.off(1.0)
    assert last is not None
    assert last.forward == 0.0
    assert hand.off(1.0) is None
