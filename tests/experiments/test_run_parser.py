"""What `iw-run` reads from its command line; what it does with it is tested with the command."""

from __future__ import annotations

import pytest

from intellwheels_experiments.run_parser import parser
from intellwheels_schemas import defaults


def test_defaults_are_those_of_a_single_run_on_this_machine() -> None:
    found = parser().parse_args(["figure6"])
    assert (found.scene, found.world, found.listen, found.connect) == ("figure6", defaults.WORLD, [], [])
    assert (found.pace, found.speed, found.view, found.branch) == (None, 1.0, False, None)


@pytest.mark.parametrize("world", ["", "a/b", "x" * 100])
def test_world_must_have_a_name(world: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        parser().parse_args(["figure6", "--world", world])
    assert refused.value.code == 2
    assert "--world" in capsys.readouterr().err
