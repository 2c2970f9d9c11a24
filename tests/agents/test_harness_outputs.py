from __future__ import annotations

from typing import get_args

from intellwheels_agents import harness_outputs


def test_outputs_are_plain_values_that_compare_equal() -> None:
    assert harness_outputs.Print("a") == harness_outputs.Print("a")
    assert harness_outputs.AskClock() == harness_outputs.AskClock()
    assert len(get_args(harness_outputs.Output)) == 9
