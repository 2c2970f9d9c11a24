"""The messages of agents that act on the next step, kept until the step is made. Pure.

Of several actions for one step the newest counts, by tick and sequence number. Fields that it leaves out keep the
values of the earlier ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, TypeVar

import msgspec

from intellwheels_schemas.file_records import Change, Inputs, Said, Verdict
from intellwheels_schemas.messages import Actions, Pose, Say, UserInput
from intellwheels_server.service.error_replies import Fault


def check_time(run: str | None, tick: int | None, now_run: str, now_tick: int, where: str) -> Fault | None:
    """Return what is wrong with the run and tick of a message, or None. A missing run or tick means the current one."""
    if run is not None and run != now_run:
        return Fault("late", f"{where}.Run: expected {now_run}, got {run}", f"{where}.Run")
    if tick is None or tick == now_tick:
        return None
    if tick < now_tick:
        return Fault("late", f"{where}.Tick: expected {now_tick}, got {tick}", f"{where}.Tick")
    return Fault("early", f"{where}.Tick: expected {now_tick}, got {tick}", f"{where}.Tick")


class InputLatch:
    """The messages that act on the step from this tick to the next."""

    def __init__(self) -> None:
        self.actions: dict[str, Actions] = {}
        self.says: dict[str, Said] = {}
        self.poses: dict[str, Pose] = {}
        self.users: dict[str, UserInput] = {}

    def act(self, agent: str, actions: Actions) -> Fault | None:
        """Keep actions, unless newer ones for this tick came before; return the fault of a say that they replace."""
        earlier = self.actions.get(agent)
        if earlier is not None:
            later = actions.tick is not None and earlier.tick is not None and actions.tick > earlier.tick
            if not later and actions.seq is not None and earlier.seq is not None and actions.seq <= earlier.seq:
                return None
            actions = _merge(earlier, actions)
        self.actions[agent] = actions
        replaced = self.says.pop(agent, None) if actions.say is not None else None
        return None if replaced is None else _second_say(replaced.seq)

    def act_first(self, actions: Mapping[str, Actions]) -> bool:
        """Keep actions without a say, one of each agent, if all of them are the first for this step; else return False.

        Then nothing is kept.
        """
        if not self.actions.keys().isdisjoint(actions):
            return False
        self.actions.update(actions)
        return True

    def set_pose(self, agent: str, pose: Pose) -> None:
        """Keep the pose of a real chair, unless a newer one for this tick came before."""
        earlier = self.poses.get(agent)
        if earlier is None or pose.seq is None or earlier.seq is None or pose.seq > earlier.seq:
            self.poses[agent] = pose

    def say(self, agent: str, say: Say) -> Fault | None:
        """Keep a say, or return its fault: one say counts a tick, and a say in actions comes first."""
        actions = self.actions.get(agent)
        if agent in self.says or (actions is not None and actions.say is not None):
            return _second_say(say.seq)
        self.says[agent] = Said(agent=agent, text=say.text, seq=say.seq)
        return None

    def set_user_input(self, agent: str, user: UserInput) -> None:
        """Keep the input of a user. The caller has checked that it is the newest."""
        self.users[agent] = user

    def forget(self, agent: str) -> None:
        """Drop the messages of an agent that is gone."""
        for latched in (self.actions, self.says, self.poses, self.users):
            latched.pop(agent, None)

    def clear(self) -> None:
        """Drop everything, for a new run."""
        self.actions, self.says, self.poses, self.users = {}, {}, {}, {}

    def collect(self, changes: tuple[Change, ...], verdicts: list[Verdict]) -> Inputs:
        """Return everything that acts on the step, sorted by name, and start to collect for the next one."""
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


def _second_say(seq: int | None) -> Fault:
    return Fault("too-many", "Say: expected one a tick, got another", "Say", seq)


_T = TypeVar("_T")
_MERGED: Final = ("left_motor", "right_motor", "mode", "goal", "say")


def _merge(earlier: Actions, later: Actions) -> Actions:
    missing = {name: getattr(earlier, name) for name in _MERGED if getattr(later, name) is None}
    if earlier.leave:
        missing["leave"] = True
    return msgspec.structs.replace(later, **missing)


def _sorted(latched: dict[str, _T]) -> dict[str, _T]:
    return dict(sorted(latched.items()))
