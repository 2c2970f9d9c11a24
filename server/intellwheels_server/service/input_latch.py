"""What agents sent that acts on the next step, collected until it is made. Pure.

Of several actions for one tick the newest counts, by (Tick, Seq); what it does not say stands as it was said before.
"""

from __future__ import annotations

from typing import Final, TypeVar

import msgspec

from intellwheels_schemas.messages import Actions, Pose, Say, UserInput
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.world.inputs import Change, Inputs, Said, Verdict


def check_time(run: str | None, tick: int | None, now_run: str, now_tick: int, where: str) -> Fault | None:
    """Return what is wrong with a message's run and tick, or None. Absent ones mean now."""
    if run is not None and run != now_run:
        return Fault("late", f"{where}.Run: expected {now_run}, got {run}", f"{where}.Run")
    if tick is None or tick == now_tick:
        return None
    if tick < now_tick:
        return Fault("late", f"{where}.Tick: expected {now_tick}, got {tick}", f"{where}.Tick")
    return Fault("early", f"{where}.Tick: expected {now_tick}, got {tick}", f"{where}.Tick")


class InputLatch:
    """What is to act on the step from this tick to the next."""

    def __init__(self) -> None:
        self.actions: dict[str, Actions] = {}
        self.says: dict[str, Said] = {}
        self.poses: dict[str, Pose] = {}
        self.users: dict[str, UserInput] = {}

    def act(self, agent: str, actions: Actions) -> Fault | None:
        """Latch actions, unless newer ones of this tick are here; return what is wrong with a say they put aside."""
        earlier = self.actions.get(agent)
        if earlier is not None:
            if actions.seq is not None and earlier.seq is not None and actions.seq <= earlier.seq:
                return None
            actions = _overlay(earlier, actions)
        self.actions[agent] = actions
        said = self.says.pop(agent, None) if actions.say is not None else None
        return None if said is None else _another_say(said.seq)

    def report(self, agent: str, pose: Pose) -> None:
        """Latch a real chair's pose, unless a newer one of this tick is here."""
        earlier = self.poses.get(agent)
        if earlier is None or pose.seq is None or earlier.seq is None or pose.seq > earlier.seq:
            self.poses[agent] = pose

    def say(self, agent: str, say: Say) -> Fault | None:
        """Latch words; one say a tick, and that of the actions goes before."""
        actions = self.actions.get(agent)
        if agent in self.says or (actions is not None and actions.say is not None):
            return _another_say(say.seq)
        self.says[agent] = Said(agent=agent, text=say.text, seq=say.seq)
        return None

    def use(self, agent: str, user: UserInput) -> None:
        """Latch a user's input; whether it is the newest has been judged."""
        self.users[agent] = user

    def forget(self, agent: str) -> None:
        """Forget what an agent that is gone sent."""
        for latched in (self.actions, self.says, self.poses, self.users):
            latched.pop(agent, None)

    def clear(self) -> None:
        """Forget everything: a new run."""
        self.actions, self.says, self.poses, self.users = {}, {}, {}, {}

    def collect(self, changes: tuple[Change, ...], verdicts: list[Verdict]) -> Inputs:
        """Return everything that acts on the step, sorted by name, and begin to latch for the next."""
        inputs = Inputs(
            changes=changes,
            actions=_sorted(self.actions),
            says=tuple(_sorted(self.says).values()),
            poses=_sorted(self.poses),
            user_input=_sorted(self.users),
            verdicts=tuple(verdicts),
        )
        self.clear()
        return inputs


def _another_say(seq: int | None) -> Fault:
    return Fault("too-many", "Say: expected one a tick, got another", "Say", seq)


_T = TypeVar("_T")
_KEPT: Final = ("left_motor", "right_motor", "mode", "goal", "say")


def _overlay(earlier: Actions, later: Actions) -> Actions:
    kept = {name: getattr(earlier, name) for name in _KEPT if getattr(later, name) is None}
    if earlier.leave:
        kept["leave"] = True
    return msgspec.structs.replace(later, **kept)


def _sorted(latched: dict[str, _T]) -> dict[str, _T]:
    return dict(sorted(latched.items()))
