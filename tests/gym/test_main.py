"""The package itself: what it registers, and what it says where its extra is missing."""

from __future__ import annotations

import importlib
import sys

import gymnasium
import pytest

import intellwheels_gym


def test_environment_is_registered_and_every_public_name_is_there() -> None:
    assert "IntellWheels/Chair-v0" in gymnasium.registry
    assert all(hasattr(intellwheels_gym, name) for name in intellwheels_gym.__all__)


def test_package_says_how_to_get_what_it_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pettingzoo", None)
    with pytest.raises(ImportError, match=r"intellwheels_gym: expected the extra learn \(no module pettingzoo\): run"):
        importlib.reload(intellwheels_gym)
