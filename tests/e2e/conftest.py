"""A stage for each test."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.e2e.stage import Stage


@pytest.fixture
def stage(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Stage]:
    name = re.sub(r"[^a-z0-9]", "-", request.node.name.lower())[:30].strip("-")
    with Stage(tmp_path, f"w{name}") as stage:
        yield stage
