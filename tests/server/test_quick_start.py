"""The simulator loads its world without what it does not need, and a process is then as it was."""

from __future__ import annotations

import gc
import subprocess
import sys

import pytest

from intellwheels_server.quick_start import QuickStart

WARMS = """
import sys
from intellwheels_server.quick_start import QuickStart
quick = QuickStart()
from intellwheels_server.world.warmup import warm
warm()
print("scipy.linalg" in sys.modules)
quick.end(freeze=True)
import scipy.linalg.cython_blas
"""


def test_collector_is_off_until_the_end_and_then_as_before() -> None:
    quick = QuickStart()
    try:
        assert not gc.isenabled()
    finally:
        quick.end()
    assert gc.isenabled()


def test_second_end_changes_nothing() -> None:
    quick = QuickStart()
    quick.end()
    gc.disable()
    try:
        quick.end()
        assert not gc.isenabled()
    finally:
        gc.enable()


@pytest.mark.process
def test_kernels_are_loaded_without_scipy_which_is_found_afterwards() -> None:
    pytest.importorskip("scipy")
    done = subprocess.run([sys.executable, "-c", WARMS], capture_output=True, text=True, timeout=300.0, check=False)
    assert (done.returncode, done.stdout) == (0, "False\n"), done.stderr
