"""The README of each language: few commands, and how to check the agent."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[3] / "agents" / "examples" / "other_languages"


@pytest.mark.parametrize("language", sorted(path.name for path in EXAMPLES.iterdir()))
def test_readme_of_a_language_has_few_commands_and_the_check(language: str) -> None:
    page = (EXAMPLES / language / "README.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    assert 3 <= len(block.splitlines()) <= 4
    assert "iw-check-agent" in page
    assert "schemas/FIRST-AGENT.md" in page
