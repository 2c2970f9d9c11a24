"""The commands of the distribution, read from the list in `pyproject.toml`: whoever tests all of them asks here."""

from __future__ import annotations

import tomllib
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parent.parent

SCRIPTS: dict[str, str] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
"""The entry of each command: `iw-bridge` is `intellwheels_agents.bridge:main`."""

MODULES = {name: entry.partition(":")[0] for name, entry in SCRIPTS.items()}
"""What `python -m` runs for each command."""


def file_of(name: str) -> str:
    """Return the module that a command's code is in: of a package, its `__main__`."""
    module = MODULES[name]
    spec = find_spec(module)
    assert spec is not None, module
    return f"{module}.__main__" if spec.submodule_search_locations is not None else module
