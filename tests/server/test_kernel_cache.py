import os
import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_server import kernel_cache


@pytest.fixture(autouse=True)
def _own_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)


def test_folder_named_by_the_user_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert kernel_cache.choose() == tmp_path


def test_cache_folder_of_the_user_comes_first_and_is_private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    folder = kernel_cache.choose()
    assert folder.parent == tmp_path / ".cache" / "intellwheels"
    assert folder.stat().st_mode & 0o077 == 0
    assert os.environ["NUMBA_CACHE_DIR"] == str(folder)


def test_temporary_folder_is_used_without_a_writable_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("HOME", str(blocked))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    assert kernel_cache.choose().parent == tmp_path / f"intellwheels-{os.getuid()}"


def test_folder_of_another_user_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr("os.getuid", lambda: 12345)
    monkeypatch.setattr("tempfile.mkdtemp", lambda prefix: str(tmp_path / prefix))
    assert kernel_cache.choose() == tmp_path / "intellwheels-"


def test_digest_is_that_of_the_kernels_sources() -> None:
    assert len(kernel_cache.source_digest()) == 12
    assert kernel_cache.source_digest() == kernel_cache.source_digest()


def test_cold_folder_becomes_warm(tmp_path: Path) -> None:
    assert kernel_cache.is_cold(tmp_path)
    (tmp_path / "x-1.py27.nbi").write_bytes(b"")
    (tmp_path / "x-1.py27.1.nbc").write_bytes(b"")
    assert kernel_cache.is_cold(tmp_path)  # of another Python
    (tmp_path / f"x-1.py{sys.version_info.major}{sys.version_info.minor}.nbi").write_bytes(b"")
    assert not kernel_cache.is_cold(tmp_path)


@pytest.mark.process
def test_package_can_be_imported_if_only_the_temporary_folder_is_writable(tmp_path: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in {"HOME", "XDG_CACHE_HOME"}}
    environment.update(HOME="/proc", TMPDIR=str(tmp_path))
    code = "import intellwheels_server.world.kernels.elementary as e; print(e.sin(0.0))"
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.stdout.strip(), done.returncode) == ("0.0", 0), done.stderr
    assert any(tmp_path.rglob("*.nbc"))


def test_kernels_of_an_image_are_copied_to_a_writable_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    baked = tmp_path / "baked" / "kernels_1"
    baked.mkdir(parents=True)
    (baked / "x.nbc").write_bytes(b"code")
    (baked / f"x-1.py{sys.version_info.major}{sys.version_info.minor}.nbi").write_bytes(b"index")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv(kernel_cache.BAKED, str(tmp_path / "baked"))
    folder = kernel_cache.choose()
    assert (folder / "kernels_1" / "x.nbc").read_bytes() == b"code"
    # What was compiled since is not overwritten.
    (folder / "kernels_1" / "x.nbc").write_bytes(b"newer")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    assert (kernel_cache.choose() / "kernels_1" / "x.nbc").read_bytes() == b"newer"
