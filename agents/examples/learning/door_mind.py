"""Drives with the policy that `train.py` learned.

to       the place of the map to drive to
policy   the file of the policy (default: policy.json beside this file)
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from intellwheels_agents import Actions, Context, Measures
from intellwheels_agents.portable_math import exp
from intellwheels_gym import ActionSet, Observer

TICKS = 4
"""Ticks from one decision to the next, in training and here."""
INPUTS = 13
"""Eight ranges, distance and bearing of the goal, two speeds, and 1."""
WEIGHTS = 2 * INPUTS


def policy(weights: Sequence[float], observation: Sequence[float]) -> tuple[float, float]:
    """Return the action for an observation: v and omega as shares of the largest, v not below 0.

    Each is the hyperbolic tangent of a weighted sum of the inputs.
    """
    *ranges, distance, bearing, speed, turn_rate = observation
    inputs = [*(metres / 4.0 for metres in ranges), min(distance, 4.0) / 4.0, bearing, speed, turn_rate, 1.0]
    v, omega = (
        tanh(math.fsum(weight * value for weight, value in zip(part, inputs, strict=True)))
        for part in (weights[:INPUTS], weights[INPUTS:])
    )
    return max(v, 0.0), 0.3 * omega


def tanh(x: float) -> float:
    """Return the hyperbolic tangent of x: the same on every machine, unlike that of `math`."""
    falling = exp(-2.0 * abs(x))
    return math.copysign((1.0 - falling) / (1.0 + falling), x)


class Mind:
    """Sees and acts as in training."""

    def __init__(self, context: Context) -> None:
        goal = context.place(context.options.text("to"), "to")
        file = Path(context.options.text("policy") or Path(__file__).parent / "policy.json")
        self._weights = json.loads(file.read_text())["weights"]
        self._observer = Observer(context.robot, context.position, (goal.x, goal.y), context.parameters.period)
        self._actions = ActionSet("velocity", context.robot)
        self._powers = (0.0, 0.0)
        self._seen = 0

    def decide(self, measures: Measures) -> Actions:
        """Return the powers of the last decision, or of a new one every `TICKS` ticks."""
        self._observer.update(measures)
        if self._seen % TICKS == 0:
            self._powers = self._actions.powers(policy(self._weights, self._observer.observation().tolist()))
        self._seen += 1
        return Actions(left_motor=self._powers[0], right_motor=self._powers[1])
