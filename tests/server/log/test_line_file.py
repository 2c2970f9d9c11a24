from __future__ import annotations

import resource
from pathlib import Path

import pytest

from intellwheels_server.log.line_file import FLUSH_AFTER, LineFile


def test_lines_are_in_the_file_within_a_second_also_if_none_is_added(tmp_path: Path) -> None:
    file = LineFile(tmp_path / "f")
    file.flush_if_due(100.0)
    file.add(b"one")
    file.flush_if_due(100.0 + FLUSH_AFTER / 2.0)
    assert (tmp_path / "f").read_bytes() == b""
    file.flush_if_due(100.0 + FLUSH_AFTER)
    assert (tmp_path / "f").read_bytes() == b"one\n"
    assert FLUSH_AFTER < 0.8  # and the loop looks every 0.2 s
    file.add(b"two")
    file.close()
    assert (tmp_path / "f").read_bytes() == b"one\ntwo\n"


def test_full_disk_is_an_error_with_the_name_of_the_file() -> None:
    file = LineFile(Path("/dev/full"))
    file.add(b"one")
    with pytest.raises(OSError, match="No space left on device: '/dev/full'"):
        file.flush()
    file.close()


def test_after_a_write_that_failed_nothing_more_is_written(tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    file = LineFile(tmp_path / "f")
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (10, hard))
        file.add(b"0123456789abcdef")
        with pytest.raises(OSError, match="File too large"):
            file.flush()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    file.add(b"later")
    file.flush_if_due(1e9)
    file.close()
    assert (tmp_path / "f").read_bytes() == b"0123456789"
