"""Agents: the harness that connects an agent to the simulator, and minds that decide what it does.

Your own mind is a Python file that defines a class `Mind` or a function `make(context)`. The docstring of `mind`
shows one, and `agents/examples` in the repository is a course.
"""

from intellwheels_agents.mind import Bridge, Context, Mind
from intellwheels_agents.options import OptionError, Options
from intellwheels_schemas.messages import Actions, Measures, Pose

__all__ = ["Actions", "Bridge", "Context", "Measures", "Mind", "OptionError", "Options", "Pose"]
