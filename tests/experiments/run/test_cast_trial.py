from __future__ import annotations

import pytest

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
    assert caught.value.text.startswith("--option: agent 'chair2': option sped: expected an option of this mind (")
