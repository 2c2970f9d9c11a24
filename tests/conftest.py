"""What every test may rely on: kernels are compiled, so that no wait for a process is a wait for the compiler."""

from __future__ import annotations

import subprocess
import sys

import pytest

COMPILED = 600.0
"""Seconds for the kernels to be compiled: about 45 of CPU, once for a checkout, on machines that may be busy."""


@pytest.fixture(scope="session", autouse=True)
def _kernels() -> None:
    words = [sys.executable, "-c", "from intellwheels_server.world.warmup import warm; warm()"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=COMPILED, check=False)
    assert done.returncode == 0, done.stderr
