from __future__ import annotations

from intellwheels_agents.bridge.line_lock import LineLock
from intellwheels_schemas.names import new_hex


def test_one_at_a_time_has_a_line() -> None:
    name = f"test/{new_hex()}"
    first, second, other = LineLock(name), LineLock(name), LineLock(f"{name}2")
    assert first.take()
    assert not second.take()
    assert other.take()
    first.release()
    first.release()
    assert second.take()
    second.release()
    other.release()


def test_a_long_name_is_cut() -> None:
    lock = LineLock(f"test/{new_hex()}/" + "x" * 500)
    assert lock.take()
    lock.release()
