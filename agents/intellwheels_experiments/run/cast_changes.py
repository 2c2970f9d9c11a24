"""Changes of a scene's cast from the command line: other minds, other options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from intellwheels_experiments.run.launch_spec import is_robot_field
from intellwheels_maps.library import is_path
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Option, Scene


def with_changes(scene: Scene, minds: Sequence[str], options: Sequence[str], *, robot_fields: bool = True) -> Scene:
    """Return a scene with other minds and options.

    Args:
        scene: The scene.
        minds: Each `AGENT=MIND`.
        options: Each `AGENT.NAME=VALUE`.
        robot_fields: Whether an option may be a field of a robot.

    Raises:
        WireError: One does not have that form, its agent is not in the cast, or its option must not be changed.
    """
    cast = {one.name: one for one in scene.cast}
    for text in minds:
        agent, equals, mind = text.partition("=")
        _check(agent in cast and bool(equals and mind), "--mind", "AGENT=MIND", cast, text)
        # The options of the old mind are not for the new one. The fields of the robot stay.
        mind = str(Path(mind).absolute()) if is_path(mind) else mind
        fields = tuple(option for option in cast[agent].option if is_robot_field(option.name))
        cast[agent] = msgspec.structs.replace(cast[agent], mind=mind, option=fields)
    form = "AGENT.NAME=VALUE" if robot_fields else "AGENT.NAME=VALUE with an option of a mind"
    for text in options:
        name, equals, value = text.partition("=")
        agent, dot, option = name.partition(".")
        fits = agent in cast and bool(equals and dot and option) and (robot_fields or not is_robot_field(option))
        _check(fits, "--option", form, cast, text)
        others = tuple(one for one in cast[agent].option if one.name != option)
        cast[agent] = msgspec.structs.replace(cast[agent], option=(*others, Option(name=option, value=value)))
    return msgspec.structs.replace(scene, cast=tuple(cast.values()))


def _check(fits: bool, option: str, form: str, cast: Mapping[str, Cast], got: str) -> None:
    if not fits:
        known = ", ".join(cast)
        raise WireError(
            "value", f"{option}: expected {form}, with an agent of the scene ({known}), got {got!r}", option
        )
