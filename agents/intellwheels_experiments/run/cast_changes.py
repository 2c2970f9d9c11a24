"""Changes of a scene's cast from the command line: other minds, other programs, other options."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec

from intellwheels_experiments.run.launch_spec import is_robot_field
from intellwheels_maps.library import is_path
from intellwheels_schemas.command_line import words_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Option, Scene
from intellwheels_schemas.scene_rules import bridged_agents


def with_changes(
    scene: Scene,
    minds: Sequence[str],
    options: Sequence[str],
    commands: Sequence[str] = (),
    *,
    robot_fields: bool = True,
) -> Scene:
    """Return a scene with other minds, programs and options, in all rows of its experiment.

    Args:
        scene: The scene.
        minds: Each `AGENT=MIND`.
        options: Each `AGENT.NAME=VALUE`.
        commands: Each `AGENT=COMMAND`, the command line of a program that starts in the working directory.
        robot_fields: Whether an option may be a field of a robot.

    Raises:
        WireError: One does not have that form, its agent is not in the cast, or its option must not be changed.
    """
    changed: set[str] = set()
    for option, form, texts in (("--mind", "AGENT=MIND", minds), ("--command", "AGENT=COMMAND", commands)):
        for text in texts:
            agent, equals, value = text.partition("=")
            _check(bool(equals and value), agent, option, form, scene, text)
            if agent in changed:
                raise WireError("value", f"{option}: expected one --mind or --command for {agent!r}, got two", option)
            changed.add(agent)
            scene = _recast(scene, agent, _with_mind(value) if option == "--mind" else _with_command(value, scene))
    form = "AGENT.NAME=VALUE" if robot_fields else "AGENT.NAME=VALUE with an option of a mind"
    for text in options:
        name, equals, value = text.partition("=")
        agent, dot, option = name.partition(".")
        fits = bool(equals and dot and option) and (robot_fields or not is_robot_field(option))
        _check(fits, agent, "--option", form, scene, text)
        scene = _recast(scene, agent, _with_option(Option(name=option, value=value), bridged_agents(scene)))
    return scene


def _with_mind(mind: str) -> Callable[[Cast], Cast]:
    mind = str(Path(mind).absolute()) if is_path(mind) else mind

    def change(cast: Cast) -> Cast:
        # The options of the old mind are not for the new one. The fields of the robot stay.
        fields = tuple(option for option in cast.option if is_robot_field(option.name))
        return msgspec.structs.replace(cast, mind=mind, command=None, folder=None, option=fields)

    return change


def _with_command(line: str, scene: Scene) -> Callable[[Cast], Cast]:
    bridged = bridged_agents(scene)

    def change(cast: Cast) -> Cast:
        words_of(line, f"--command: {cast.name}")
        # The program brings its own body, unless the body is a bridge.
        body = cast.name in bridged
        return msgspec.structs.replace(
            cast,
            mind="",
            command=line,
            folder=str(Path.cwd()),
            robot=cast.robot if body else "",
            option=tuple(option for option in cast.option if body and is_robot_field(option.name)),
        )

    return change


def _with_option(option: Option, bridged: set[str]) -> Callable[[Cast], Cast]:
    def change(cast: Cast) -> Cast:
        if cast.command is not None and not (cast.name in bridged and is_robot_field(option.name)):
            text = f"--option: expected an agent with a mind, got {cast.name!r}; write options into its Command"
            raise WireError("value", text, "--option")
        others = tuple(one for one in cast.option if one.name != option.name)
        return msgspec.structs.replace(cast, option=(*others, option))

    return change


def _recast(scene: Scene, agent: str, change: Callable[[Cast], Cast]) -> Scene:
    """Return the scene with an agent changed, also where a level of the experiment replaces or adds it."""

    def changed(casts: tuple[Cast, ...]) -> tuple[Cast, ...]:
        return tuple(change(cast) if cast.name == agent else cast for cast in casts)

    experiment = scene.experiment
    if experiment is not None:
        factors = [
            msgspec.structs.replace(
                factor,
                level=tuple(msgspec.structs.replace(level, cast=changed(level.cast)) for level in factor.level),
            )
            for factor in experiment.factor
        ]
        experiment = msgspec.structs.replace(experiment, factor=tuple(factors))
    return msgspec.structs.replace(scene, cast=changed(scene.cast), experiment=experiment)


def _agents(scene: Scene) -> list[str]:
    levels = [level for factor in (scene.experiment.factor if scene.experiment else ()) for level in factor.level]
    return list(dict.fromkeys(cast.name for casts in (scene.cast, *(level.cast for level in levels)) for cast in casts))


def _check(fits: bool, agent: str, option: str, form: str, scene: Scene, got: str) -> None:
    known = _agents(scene)
    if fits and agent in known:
        return
    near = difflib.get_close_matches(agent, known, n=1) if agent not in known else []
    hint = f"; did you mean {near[0]!r}?" if near else ""
    listed = ", ".join(known) or "it has none"
    text = f"{option}: expected {form}, with an agent of the scene ({listed}), got {got!r}{hint}"
    raise WireError("value", text, option)
