"""A start for a project of one's own: mind, body, scene and test, that run as they are. Nothing is overwritten.

The test's file has another name here, so that a search for tests never finds it in an installed package.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Final

FILES: Final = {
    "README.md": "README.md",
    "mind.py": "mind.py",
    "robot.xml": "robot.xml",
    "scene.xml": "scene.xml",
    "trial.py": "test_mind.py",
}
"""The files as they are here, and their names in the new folder."""


def write(folder: Path) -> list[Path]:
    """Write the starter into a folder, which is made if it is not there, and return the files.

    Raises:
        FileExistsError: One of the files is there already; then none is written.
        OSError: They cannot be written.
    """
    wanted = {name: folder / target for name, target in FILES.items()}
    there = [path.name for path in wanted.values() if path.exists()]
    if there:
        raise FileExistsError(f"{folder}: expected none of the starter's files, got {', '.join(there)}")
    folder.mkdir(parents=True, exist_ok=True)
    for name, path in wanted.items():
        # Exclusively: what came in between is not overwritten either.
        with path.open("xb") as file:
            file.write(files(__name__).joinpath("template", name).read_bytes())
    return list(wanted.values())
