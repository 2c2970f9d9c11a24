"""Test an agent with pytest over real processes: the fixture `intellwheels` starts worlds and ends them.

    def test_chair_touches_nobody(intellwheels):
        sim = intellwheels(floor="corner", seed="1")
        sim.agent("chair1", mind="my_mind.py", robot="rear-wheel", place="leader")
        sim.run_until(lambda now: now["chair1"].x > 8.0, seconds=20.0)
        assert sim.contacts == []

`rig.Rig` says all that a world can do. pytest loads this file at every start, in projects that have nothing to do with
us too: what is heavy is imported when the fixture is used.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from intellwheels_experiments.testing.rig import Rig

RIGS = pytest.StashKey[list["Rig"]]()


@pytest.fixture
def intellwheels(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Callable[..., Rig]]:
    """Start a world: `intellwheels(floor="corner", pace="lockstep", seed="1")`; takes what `rig.Rig` takes.

    Relative paths start from the test's own folder. All processes end with the test; when it fails, its report shows
    what they printed last.
    """
    from intellwheels_experiments.testing.rig import Rig  # noqa: PLC0415 - heavy, see above

    rigs = request.node.stash.setdefault(RIGS, [])
    with ExitStack() as stack:

        def start(**options: Any) -> Rig:
            folder = options.pop("folder", request.path.parent)
            rig = Rig(tmp_path / f"intellwheels-{len(rigs) + 1}", folder=folder, **options)
            # Before it starts, so that a start that fails is reported too.
            rigs.append(rig)
            return stack.enter_context(rig)

        yield start


# The older form of a wrapper: a user's pytest may be older than ours.
@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Show what the processes of a failing test printed."""
    outcome = yield
    report = outcome.get_result()
    if report.failed:
        for rig in item.stash.get(RIGS, []):
            report.sections.extend((f"intellwheels: {title}", text) for title, text in rig.sections())
