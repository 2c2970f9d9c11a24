"""Compiled kernels are found again by an installation at another place."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numba
import pytest

from intellwheels_server import kernel_locator
from intellwheels_server.kernel_locator import KernelLocator, use_kernel_locator
from intellwheels_server.world.kernels import lidar_rays


def kernel() -> None:
    """Stand for a function of a package."""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_two_installations_share_a_folder_of_compiled_kernels(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for place in ("first", "second"):
        package = tmp_path / place / "intellwheels_server"
        source = package / "world" / "kernels" / "grid.py"
        source.parent.mkdir(parents=True)
        source.write_text("")
        monkeypatch.setattr(kernel_locator, "_PACKAGE", package)
        assert KernelLocator.from_function(kernel, str(source)).get_cache_path() == str(cache / "world" / "kernels")


def test_a_folder_that_is_gone_is_made_again(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "grid.py"
    source.write_text("")
    monkeypatch.setattr(kernel_locator, "_PACKAGE", source.parent)
    for _ in range(2):
        place = KernelLocator.from_function(kernel, str(source)).get_cache_path()
        assert Path(place).is_dir()
        shutil.rmtree(cache)


def test_a_function_of_another_package_is_left_to_numba(cache: Path) -> None:
    assert KernelLocator.from_function(kernel, __file__) is None
    assert not cache.exists()


def test_kernels_use_it() -> None:
    scan: Any = lidar_rays.scan
    assert isinstance(scan._cache._impl.locator, KernelLocator)


def test_locators_named_by_the_user_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_LOCATOR_CLASSES", "InTreeCacheLocator")
    use_kernel_locator()
    assert getattr(numba.config, "CACHE_LOCATOR_CLASSES", None) == "InTreeCacheLocator"
