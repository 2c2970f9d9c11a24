"""Agents: the harness that keeps one at the simulator, and minds that decide.

A user's own mind is a Python file that defines `make(context)` or a class `Mind`; `mind` shows one.
"""

from intellwheels_agents.mind import Bridge, Context, Mind
from intellwheels_agents.options import OptionError, Options
from intellwheels_schemas.messages import Actions, Measures, Pose

__all__ = ["Actions", "Bridge", "Context", "Measures", "Mind", "OptionError", "Options", "Pose"]
