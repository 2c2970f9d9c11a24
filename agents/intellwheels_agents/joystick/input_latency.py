"""How long an input takes from its device to the motors. Pure: the times are arguments.

start   from an input that leaves neutral to the first state in which the resting motors have power
stop    from an input that becomes neutral again to the first state in which the motors have less power
put     from any change of forward or turn to handing its message to the network

A time begins when the device gave the input (`InputState.at`), as far as the device tells. It ends when the state of
the world arrives here, so it includes the mind, the wait for the next tick, and the way back.
"""

from __future__ import annotations

from statistics import median

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState


class InputLatency:
    """Measures latency from the inputs that are sent and the motor outputs that are seen.

    Attributes:
        times: The times so far, in s, by kind.
    """

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {"put": [], "start": [], "stop": []}
        self._last = NEUTRAL
        self._outputs: tuple[float, float] | None = None
        self._waiting: tuple[str, float] | None = None

    def sent(self, state: InputState, now: float) -> None:
        """Take an input whose message was just sent."""
        before, self._last = self._last, state
        if (before.forward, before.turn) == (state.forward, state.turn):
            return
        at = now if state.at is None else min(state.at, now)
        self.times["put"].append(now - at)
        is_driving = bool(state.forward or state.turn)
        was_driving = bool(before.forward or before.turn)
        self._waiting = None
        if self._outputs is not None and is_driving != was_driving and is_driving != any(self._outputs):
            self._waiting = "start" if is_driving else "stop", at

    def saw(self, left: float, right: float, now: float) -> None:
        """Take the motor outputs of a state that arrived at a time."""
        before, self._outputs = self._outputs, (left, right)
        if self._waiting is None or before is None:
            return
        kind, began = self._waiting
        power, was = abs(left) + abs(right), abs(before[0]) + abs(before[1])
        if now >= began and (power > 0.0 if kind == "start" else power < was):
            self.times[kind].append(now - began)
            self._waiting = None

    def summary(self) -> str:
        """Return the number of times of each kind, their median and their maximum in s, as `name=value` words."""
        words = []
        for kind, times in self.times.items():
            words.append(f"{kind}s={len(times)}")
            if times:
                words += [f"{kind}_median={median(times):.4f}", f"{kind}_max={max(times):.4f}"]
        return " ".join(words)
