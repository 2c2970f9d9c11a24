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
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps.library import is_path
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
        OptionError: There is no such mind or file, or the file defines no mind. Exceptions of the file itself pass.
    """
    if is_path(name_or_path):
        module = _loaded(Path(name_or_path))
    elif name_or_path in names():
        module = import_module(f"{__name__}.{name_or_path}")
    else:
        raise OptionError(f"mind: expected one of {', '.join(names())} or a Python file, got {name_or_path!r}")
    make = getattr(module, "make", None) or getattr(module, "Mind", None)
    if not callable(make):
        raise OptionError(f"{name_or_path}: expected make(context) or a class Mind, got neither")
    return Source(name_or_path, make, getattr(module, "equip", _unchanged))


def _unchanged(robot: Robot, _options: Options) -> Robot:
    return robot


def _loaded(path: Path) -> ModuleType:
    if not path.is_file():
        raise OptionError(f"{path}: expected a Python file, got none")
    # A prefixed name: a user's file called json.py must not hide the standard module.
    name = f"intellwheels_user_mind_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise OptionError(f"{path}: expected a Python file ending in .py, got {path.name!r}")
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look up their module by name, and a mind may import files from its own folder.
    sys.modules[name] = module
    sys.path.insert(0, str(path.parent.resolve()))
    spec.loader.exec_module(module)
    return module
