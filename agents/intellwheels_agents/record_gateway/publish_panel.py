"""What pages of the live view publish, as the input of users. Pure but for a lock: the time is an argument.

A page publishes JSON to `/user/<agent>`: a `UserInput`, or a twist in m/s and rad/s, as Foxglove's panels do. An input
drives the chair for a short time, in which it is repeated; then a zero is sent, once.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping
from typing import Any, Final

import msgspec

from intellwheels_schemas.codec import MAX_BYTES, Encoding, decode
from intellwheels_schemas.errors import WireError, wrong_value
from intellwheels_schemas.messages import Robot, UserInput
from intellwheels_schemas.names import is_name

PREFIX: Final = "/user/"
REPEAT_EVERY: Final = 0.1
"""Seconds between repeats: the simulator stops a chair after 0.3 s without input."""
AGAIN: Final = (0.5, 2.0, 8.0)
"""Seconds after which what a page subscribed to is sent again: the server of a busy machine may serve it late."""
ROOM: Final = 256
"""Inputs that wait; older ones are dropped."""


class PublishPanel:
    """The inputs of all pages. It is the listener of the live view: its server calls from threads of its own.

    Args:
        hold: Seconds for which an input drives a chair.
    """

    def __init__(self, hold: float) -> None:
        self._hold = hold
        self._lock = threading.Lock()
        self._topics: dict[tuple[int, int], str] = {}
        self._arrived: deque[tuple[str, bytes]] = deque(maxlen=ROOM)
        self._subscribed: deque[str] = deque(maxlen=4 * ROOM)
        self._again: dict[str, list[float]] = {}
        self._held: dict[str, tuple[UserInput, float]] = {}
        self._due = 0.0

    # ------------------------------------------------------------ called by the server

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        """Note the topic of a page's channel."""
        with self._lock:
            if len(self._topics) < 16 * ROOM:
                self._topics[client.id, channel.id] = channel.topic

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        """Forget a page's channel."""
        with self._lock:
            self._topics.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        """Keep what a page published."""
        with self._lock:
            topic = self._topics.get((client.id, client_channel_id))
            if topic is not None and len(data) <= MAX_BYTES:
                self._arrived.append((topic, data))

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        """Note that a page wants a topic."""
        with self._lock:
            self._subscribed.append(channel.topic)

    # ------------------------------------------------------------ called by the loop

    def subscribed(self, now: float) -> list[str]:
        """Return the topics that pages have subscribed to since the last call, and each again after `AGAIN`.

        The server may call back before it serves the subscription: what is sent at once may reach nobody.

        Args:
            now: A monotonic clock, s.
        """
        with self._lock:
            found = list(dict.fromkeys(self._subscribed))
            self._subscribed.clear()
        due = [topic for topic, times in self._again.items() if now >= times[0]]
        for topic in due:
            self._again[topic] = [at for at in self._again[topic] if now < at]
        self._again |= {topic: [now + after for after in AGAIN] for topic in found}
        self._again = {topic: times for topic, times in self._again.items() if times}
        return list(dict.fromkeys([*found, *due]))

    def inputs(self, robots: Mapping[str, Robot], now: float) -> tuple[list[tuple[str, UserInput]], list[str]]:
        """Return the inputs to send now, by agent, and what is wrong with others, as lines for people.

        Args:
            robots: The bodies, by agent.
            now: A monotonic clock, s.
        """
        with self._lock:
            arrived = list(self._arrived)
            self._arrived.clear()
        wrong, fresh = [], False
        for topic, data in arrived:
            try:
                agent = _agent_of(topic, robots)
                self._held[agent] = (user_input(data, robots[agent]), now + self._hold)
                fresh = True
            except WireError as error:
                wrong.append(error.text)
        if not self._held or (now < self._due and not fresh):
            return [], wrong
        self._due = now + REPEAT_EVERY
        found = [(agent, user if now < until else UserInput()) for agent, (user, until) in self._held.items()]
        self._held = {agent: held for agent, held in self._held.items() if now < held[1]}
        return found, wrong


def user_input(data: bytes, robot: Robot) -> UserInput:
    """Return what a page published as an input.

    Raises:
        WireError: It is neither a `UserInput` in JSON, nor a twist, or the chair of a twist has no motors.
    """
    try:
        twist = msgspec.json.decode(data, type=_Twist)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        user = decode(UserInput, data, Encoding.JSON)
        if user.lease is not None:
            raise wrong_value("UserInput.Lease", "none", "one") from None
        return user
    if robot.top_speed <= 0.0:
        raise wrong_value("twist", "a body with motors", "one without")
    forward = twist.linear.x / robot.top_speed
    turn = twist.angular.z * robot.track / (2.0 * robot.top_speed)
    return UserInput(forward=max(-1.0, min(forward, 1.0)), turn=max(-1.0, min(turn, 1.0)))


class _Vector(msgspec.Struct):
    x: float = 0.0
    z: float = 0.0


class _Twist(msgspec.Struct):
    """A twist: m/s and rad/s."""

    linear: _Vector
    angular: _Vector


def _agent_of(topic: str, robots: Mapping[str, Robot]) -> str:
    agent = topic.removeprefix(PREFIX)
    if not topic.startswith(PREFIX) or not is_name(agent) or agent not in robots:
        raise wrong_value("topic", f"{PREFIX} and an agent that is here", repr(topic[:80]))
    return agent
