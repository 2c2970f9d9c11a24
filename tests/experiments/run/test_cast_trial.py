from __future__ import annotations

import sys

import pytest

from intellwheels_experiments.run import cast_trial
from intellwheels_experiments.run.cast_changes import with_changes
from intellwheels_experiments.run.cast_trial import check_cast
from intellwheels_maps import scene
from intellwheels_schemas.errors import WireError

pytestmark = pytest.mark.process


def test_a_cast_that_can_start_and_one_that_cannot() -> None:
    found = scene("figure6")
    check_cast([found], None, "SCENE")
    with pytest.raises(WireError) as caught:
        check_cast([found, with_changes(found, [], ["chair2.sped=1"])], None, "--option")
    with pytest.raises(WireError, match=r"^--option: agent 'chair1': option MotorNoise: expected .*, got '007'$"):
        check_cast([with_changes(found, [], ["chair1.MotorNoise=007"])], None, "--option")
    assert caught.value.text.startswith("--option: agent 'chair2': option sped: expected an option of this mind (")


def test_a_check_that_fails_is_told_by_its_last_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cast_trial, "PYTHON", (sys.executable, "-c", "import sys; raise ValueError('no map')"))
    with pytest.raises(WireError, match=r"^SCENE: ValueError: no map$"):
        check_cast([scene("figure6")], None, "SCENE")
