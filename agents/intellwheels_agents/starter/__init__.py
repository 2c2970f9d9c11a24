"""The starter project of `iw-agent new`: a mind, a robot, a scene and tests, ready to run. It overwrites no file.

The test file has another name in the package, so that pytest never collects it from an installed package.
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
"""The files of the template, and their names in the new folder."""


def write(folder: Path) -> list[Path]:
    """Write the starter project into a folder, created if needed, and return the files.

    Raises:
        FileExistsError: One of the files exists already; then none is written.
        OSError: A file cannot be written.
    """
    targets = {name: folder / target for name, target in FILES.items()}
    existing = [path.name for path in targets.values() if path.exists()]
    if existing:
        raise FileExistsError(f"{folder}: expected none of the starter's files, got {', '.join(existing)}")
    folder.mkdir(parents=True, exist_ok=True)
    for name, path in targets.items():
        # Mode x: a file that appeared since the check is not overwritten either.
        with path.open("xb") as file:
            file.write(files(__name__).joinpath("template", name).read_bytes())
    return list(targets.values())
