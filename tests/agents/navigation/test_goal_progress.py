"""Progress is a falling cost."""

from __future__ import annotations

from intellwheels_agents.navigation.goal_progress import Progress


def test_stalled_counts_from_the_last_gain() -> None:
    progress = Progress()
    progress.update(0.0, 10.0)
    progress.update(1.0, 9.0)
    progress.update(2.0, 8.99)
    progress.update(3.0, 9.5)
    assert progress.stalled == 2.0
    progress.reset(4.0)
    assert progress.stalled == 0.0
    progress.update(4.5, 12.0)
    assert progress.stalled == 0.0
