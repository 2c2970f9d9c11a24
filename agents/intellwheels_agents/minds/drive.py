"""Drives without looking: with fixed motor powers, or with a script of them.

    left, right   motor powers (default 0)
    script        "time:left,right; time:left,right": the powers from each time on, in simulated seconds; 0 before the
                  first time; not with left or right
    say           a message, sent once at the first tick

It ignores its sensors, so it drives into anything in its way.
"""

from __future__ import annotations

from bisect import bisect_right

from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_schemas.messages import Actions, Measures


class Mind:
    """Gives the powers of its options."""

    def __init__(self, context: Context) -> None:
        options = context.options
        fixed = options.number("left", 0.0, -1.0, 1.0), options.number("right", 0.0, -1.0, 1.0)
        self._times, self._powers = _script(options)
        if not self._times:
            self._times, self._powers = [0.0], [fixed]
        elif "left" in options or "right" in options:
            raise OptionError("option script: expected either a script or left and right, got both")
        self._say: str | None = options.text("say") or None

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for the present time."""
        say, self._say = self._say, None
        # The time of a tick may be slightly below the decimal number in the script.
        index = bisect_right(self._times, measures.time + 1e-9) - 1
        left, right = self._powers[index] if index >= 0 else (0.0, 0.0)
        return Actions(left_motor=left, right_motor=right, say=say)


def _script(options: Options) -> tuple[list[float], list[tuple[float, float]]]:
    times: list[float] = []
    powers: list[tuple[float, float]] = []
    for line in filter(None, (part.strip() for part in options.text("script").split(";"))):
        try:
            time, _, both = line.partition(":")
            left, right = (float(word) for word in both.split(","))
            at = float(time)
        except ValueError:
            raise OptionError(f"option script: expected time:left,right, got {line!r}") from None
        if not (-1.0 <= left <= 1.0 and -1.0 <= right <= 1.0):
            raise OptionError(f"option script: expected powers in [-1, 1], got {line!r}")
        if not at >= 0.0 or (times and at <= times[-1]):
            raise OptionError(f"option script: expected times that grow from 0, got {line!r}")
        times.append(at)
        powers.append((left, right))
    return times, powers
