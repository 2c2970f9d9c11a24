"""The included minds, one file each. A file is a mind if it defines a class `Mind` or a function `make(context)`.

It may also define `equip(robot, options)`, which returns the robot to join with, for example with a sensor that an
option asks for.
"""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType

from intellwheels_agents.mind import Equip, Make
from intellwheels_agents.mind_error import failed
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps.library import is_path
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.messages import Robot


@dataclass(frozen=True)
class Source:
    """The functions that the file of a mind provides.

    Attributes:
        name: The name or path that was asked for.
        make: Makes a mind from its context.
        equip: Returns the robot that the mind needs.
    """

    name: str
    make: Make
    equip: Equip


def names() -> list[str]:
    """Return the names of the included minds, sorted."""
    entries = [entry.name for entry in files(__name__).iterdir()]
    return sorted(name[:-3] for name in entries if name.endswith(".py") and not name.startswith("_"))


def find(name_or_path: str) -> Source:
    """Return what the file of a mind provides.

    Args:
        name_or_path: The name of an included mind, or the path of a Python file.

    Raises:
        OptionError: There is no such mind or file, or the file fails or defines no mind.
    """
    if is_path(name_or_path):
        module = _loaded(Path(name_or_path))
    elif name_or_path in names():
        module = import_module(f"{__name__}.{name_or_path}")
    else:
        known = names()
        expected = f"MIND: expected one of {', '.join(known)} or a Python file"
        raise OptionError(f"{expected}, got {name_or_path!r}{did_you_mean(name_or_path, known)}")
    make = getattr(module, "make", None) or getattr(module, "Mind", None)
    if not callable(make):
        raise OptionError(f"MIND: {name_or_path}: expected make(context) or a class Mind, got neither")
    return Source(name_or_path, make, getattr(module, "equip", _unchanged))


def _unchanged(robot: Robot, _options: Options) -> Robot:
    return robot


def _loaded(path: Path) -> ModuleType:
    if not path.is_file():
        got = "a folder" if path.is_dir() else "none"
        raise OptionError(f"MIND: {path}: expected a Python file, got {got}")
    # A prefixed name: a user's file called json.py must not hide the standard module.
    name = f"intellwheels_user_mind_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise OptionError(f"MIND: {path}: expected a Python file ending in .py, got {path.name!r}")
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look up their module by name, and a mind may import files from its own folder.
    sys.modules[name] = module
    sys.path.insert(0, str(path.parent.resolve()))
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        place = f"{error.filename}:{error.lineno}"
        raise OptionError(f"MIND: {place}: expected Python, got a syntax error: {error.msg}") from error
    except Exception as error:
        raise OptionError(f"MIND: {failed(path, error)}") from error
    return module
