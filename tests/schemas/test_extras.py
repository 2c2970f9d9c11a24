"""The table of extras agrees with `pyproject.toml`, and the sentence names what is missing."""

import re
import sys
import tomllib
from importlib.metadata import packages_distributions

import pytest

from intellwheels_schemas.extras import MODULES, missing_extra
from tests.commands import ROOT

EXTRAS: dict[str, list[str]] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


def test_every_extra_has_the_modules_of_its_distributions() -> None:
    assert MODULES.keys() == EXTRAS.keys() - {"all", "test"}
    owners = packages_distributions()
    for extra, modules in MODULES.items():
        wanted = {re.split(r"[><=]", line)[0].replace("_", "-").lower() for line in EXTRAS[extra]}
        found = {owner.replace("_", "-").lower() for name in modules for owner in owners[name]}
        assert found >= wanted, extra
        assert len(modules) == len(wanted), extra


def test_nothing_is_missing_where_all_is_installed() -> None:
    assert missing_extra(*MODULES) is None


def test_what_is_missing_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    expected = "expected the extra bridge (no module serial): run pip install '.[bridge]' in the project's folder"
    assert missing_extra("server", "bridge") == expected
    monkeypatch.setitem(sys.modules, "viser", None)
    assert missing_extra("viewer", "bridge") == (
        "expected the extras viewer, bridge (no module viser, serial): "
        "run pip install '.[viewer,bridge]' in the project's folder"
    )


def test_no_hint_names_a_package_index() -> None:
    texts = [*ROOT.glob("*/intellwheels_*/**/*.py"), *ROOT.glob("**/*.md")]
    pattern = re.compile(r"pip install ['\"]?intellwheels")
    assert texts
    assert [str(path) for path in texts if ".venv" not in path.parts and pattern.search(path.read_text())] == []
