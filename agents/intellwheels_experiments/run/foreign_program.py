"""The program of a `Command`: checked before anything starts, then started like the project's own agents."""

from __future__ import annotations

import contextlib
import difflib
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.launch_spec import agent_child
from intellwheels_schemas.command_line import filled, words_of
from intellwheels_schemas.errors import WireError, wrong_value
from intellwheels_schemas.messages import Cast
from intellwheels_schemas.process import PYTHON


def check_programs(cast: Sequence[Cast], folder: Path | None, meeting: Sequence[str] | None = None) -> None:
    """Check that the programs of a cast can be started.

    Args:
        cast: The agents.
        folder: Where relative folders start; None: the working directory.
        meeting: The endpoints to which the programs can connect; None if they are not known yet.

    Raises:
        WireError: One cannot; the text names its agent.
    """
    for one in cast:
        if one.command is None:
            continue
        where = f"agent {one.name!r}: Command"
        words = words_of(one.command, where)
        if meeting is not None and not meeting and any("{endpoint}" in word for word in words):
            raise wrong_value(where, "--connect with an endpoint for {endpoint}", "none")
        check_program(filled(words[0], {"name": one.name}), folder_of(one, folder), where)


def folder_of(cast: Cast, folder: Path | None) -> Path:
    """Return the folder in which the program of an agent starts."""
    return (folder or Path()).absolute() / (cast.folder or "")


def launch_agent(
    children: ChildProcesses,
    cast: Cast,
    command: Callable[[int], Sequence[str]],
    values: Mapping[str, str],
    folder: Path | None,
) -> str:
    """Start an agent of a scene, and return the name of the child.

    Args:
        children: The processes of the run.
        cast: The agent, with a mind or a command.
        command: Makes the command line of its mind from the file descriptor of the lifeline.
        values: What replaces `{endpoint}` and `{world}` in a command.
        folder: Where relative folders start; None: the working directory.

    Raises:
        OSError: It cannot be started.
    """
    child = agent_child(cast.name)
    if cast.command is None:
        return children.launch(child, command)
    words = words_of(cast.command, f"agent {cast.name!r}: Command")
    return launch_program(children, child, words, {"name": cast.name, **values}, folder_of(cast, folder))


def launch_program(
    children: ChildProcesses, child: str, words: Sequence[str], values: Mapping[str, str], folder: Path
) -> str:
    """Start a program, with the lifeline of the run, and return the name of the child.

    Args:
        children: The processes of the run.
        child: The name to start it under.
        words: Its command line.
        values: What replaces the placeholders. The program also finds them in its environment, as IW_NAME and so on.
        folder: Where it starts.

    Raises:
        OSError: The guard beside it cannot be started.
    """
    command = [filled(word, values) for word in words]
    environment = {"PATH": _search_path(), **{f"IW_{name.upper()}": value for name, value in values.items()}}
    return children.launch(child, guarded(command, folder), environment)


def guarded(command: Sequence[str], folder: Path) -> Callable[[int], Sequence[str]]:
    """Return what makes the command line of a program with its guard, from the file descriptor of the lifeline."""
    guard = [*PYTHON, "-m", "intellwheels_experiments.run.program_guard"]
    return lambda lifeline: [*guard, str(lifeline), str(folder), *command]


def check_program(program: str, folder: Path, where: str) -> None:
    """Check that a program can be started.

    Args:
        program: The first word of its command line.
        folder: Where it starts.
        where: The place of its command line, for the error.

    Raises:
        WireError: It cannot.
    """
    if not _is_there(folder.is_dir):
        raise wrong_value(where, "a folder to start in", f"{str(folder)!r}")
    if "/" not in program:
        if shutil.which(program, path=_search_path()) is None:
            own = f"./{program}" if _is_there((folder / program).is_file) else None
            raise _missing(
                where, program, own or _near(program, _names_in(map(Path, _search_path().split(os.pathsep))))
            )
        return
    path = folder / program
    if not _is_there(path.is_file):
        near = _near(path.name, _names_in([path.parent]))
        raise _missing(where, program, near and f"{program.rpartition('/')[0]}/{near}")
    if not os.access(path, os.X_OK):
        raise wrong_value(where, "a program that can be started (chmod +x)", f"{program!r}")


def _missing(where: str, program: str, near: str | None) -> WireError:
    hint = f"; did you mean {near!r}?" if near else ""
    return wrong_value(where, "a program", f"{program!r}, which does not exist{hint}")


def _near(name: str, known: Sequence[str]) -> str | None:
    found = difflib.get_close_matches(name, known, n=1)
    return found[0] if found else None


def _is_there(look: Callable[[], bool]) -> bool:
    try:
        return look()
    except OSError:  # in a folder that may not be read, or under a name that no file can have
        return False


def _names_in(folders: Iterable[Path]) -> list[str]:
    names: set[str] = set()
    for folder in folders:
        with contextlib.suppress(OSError):  # no folder, or one that may not be read
            names |= {path.name for path in folder.iterdir()}
    return sorted(names)


def _search_path() -> str:
    """Return where programs are looked for: first beside this Python, whose packages a `python` in a line can use."""
    return os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
