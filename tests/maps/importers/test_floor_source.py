from __future__ import annotations

import pytest

from intellwheels_maps.importers.floor_source import FloorSource, check_no_level, chosen_level
from intellwheels_schemas.errors import WireError

SOURCE = FloorSource("a.yaml", b"", lambda _: b"", "L9")


def test_the_first_level_counts_unless_one_is_chosen() -> None:
    assert chosen_level(SOURCE._replace(level=None), ["L1", "L2"]) == "L1"
    assert chosen_level(SOURCE._replace(level="L2"), ["L1", "L2"]) == "L2"


def test_a_level_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(WireError, match=r"^a\.yaml: expected one of the levels \(L1, L2\) after '#', got 'L9'"):
        chosen_level(SOURCE, ["L1", "L2"])
    with pytest.raises(WireError, match="expected at least one level, got none"):
        chosen_level(SOURCE, [])
    with pytest.raises(WireError, match="this format has no levels, got 'L9'"):
        check_no_level(SOURCE)
