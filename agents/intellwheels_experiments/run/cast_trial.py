"""Asks the agents' package whether the cast of a scene can start, in a process, before anything else is started."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from intellwheels_schemas.codec import encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Scene
from intellwheels_schemas.process import PYTHON

LIMIT: Final = 60.0
"""Seconds for the check, on a machine that may be busy. Without an answer the run starts, and its agents report."""


def check_cast(scenes: Iterable[Scene], folder: Path | None, option: str) -> None:
    """Check the minds, options, robots and starting places of scenes.

    Args:
        scenes: The scenes of a run, or of the rows of a batch.
        folder: Where relative paths in them start; None: the working directory.
        option: What the user gave, for the error.

    Raises:
        WireError: An agent cannot start as it is; the text says which, and why.
    """
    command = [*PYTHON, "-m", "intellwheels_agents.cast_check"]
    if folder is not None:
        command += ["--folder", str(folder)]
    try:
        done = subprocess.run(
            command, input=b"\n".join(map(encode, scenes)), capture_output=True, timeout=LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        return
    if done.returncode > 0:
        text = done.stderr.decode(errors="replace").strip()
        # Any other code than 2 is that of an error with a traceback, whose last line says what it is.
        why = text if done.returncode == 2 else text.rpartition("\n")[2]
        raise WireError("value", f"{option}: {why}", option)
