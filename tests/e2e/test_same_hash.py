"""The same hashes with another C library: the minds of a scene do not use its sine."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

OLDER_PROCESSOR = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable"
"""Makes glibc take the functions that it has for processors without these instructions. Names that a version of glibc
does not know have no effect."""
SCENES = ("crossing:110", "corner:80", "figure6:60")
"""With the C library's functions in the minds, `crossing` differs from tick 100 on."""


def hashes(**environment: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-m", "tests.agents.scene_hashes", *SCENES],
        cwd=Path(__file__).parents[2], env={**os.environ, **environment},
        capture_output=True, text=True, timeout=180.0, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_scenes_have_the_same_hashes_with_another_c_library() -> None:
    library, *here = hashes()
    other_library, *there = hashes(GLIBC_TUNABLES=OLDER_PROCESSOR)
    if other_library == library:
        pytest.skip("math.sin and others of this C library are the same with GLIBC_TUNABLES: nothing to compare")
    assert len(here) == len(SCENES)
    assert there == here
