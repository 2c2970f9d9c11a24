"""An agent runs on a chair's own computer, so the base install must be enough for it."""

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


def test_agents_import_without_the_dependencies_of_the_server() -> None:
    subprocess.run([sys.executable, "-c", BLOCKED], check=True, timeout=30)


def test_harness_and_minds_import_without_zenoh() -> None:
    subprocess.run([sys.executable, "-c", PURE], check=True, timeout=30)
