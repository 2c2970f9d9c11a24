from __future__ import annotations

import queue

import pytest

from intellwheels_agents import decision_watch
from intellwheels_agents.decision_watch import DecisionWatch


def test_slow_decision_is_reported_once_and_a_quick_one_never(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decision_watch, "SLOW_DECISION", 0.02)
    monkeypatch.setattr(decision_watch, "WATCH_PERIOD", 0.01)
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    with DecisionWatch(lines.put) as watch:
        watch.begin()
        line = lines.get(timeout=5.0)
        assert line.startswith("slow decide=0.02s at=")
        with pytest.raises(queue.Empty):
            lines.get(timeout=0.1)
        watch.end()
        with pytest.raises(queue.Empty):
            lines.get(timeout=0.1)
