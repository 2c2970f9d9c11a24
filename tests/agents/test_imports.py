"""An agent runs on a chair's own computer: the base install is enough for it."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

BLOCKED = """
import sys
for name in ("numpy", "numba", "shapely", "viser"):
    sys.modules[name] = None
import importlib
from intellwheels_agents import minds
import intellwheels_agents.__main__, intellwheels_agents.agent_peer
for name in minds.names():
    minds.find(name)
"""
PURE = """
import sys
sys.modules["zenoh"] = None
import intellwheels_agents.harness
from intellwheels_agents import minds
for name in minds.names():
    minds.find(name)
"""


def test_everything_of_the_agents_imports_without_what_the_server_needs() -> None:
    subprocess.run([sys.executable, "-c", BLOCKED], check=True, timeout=30)


def test_the_harness_and_all_minds_import_without_zenoh() -> None:
    subprocess.run([sys.executable, "-c", PURE], check=True, timeout=30)
