"""The pytest fixture `intellwheels`: tests an agent in a simulated world, with real processes.

    def test_chair_touches_nothing(intellwheels):
        sim = intellwheels(floor="corner", seed="1")
        sim.agent("chair1", mind="my_mind.py", robot="rear-wheel", place="leader")
        sim.run_until(lambda now: now["chair1"].x > 8.0, seconds=20.0)
        assert sim.contacts == []

`python -m pydoc intellwheels_experiments.testing.rig` describes everything that `sim` can do. pytest loads this file
whenever it starts, in other projects too. So heavy modules are imported only when the fixture is used.
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
    """Start simulated worlds for a test, each as a running `Rig`.

    For example `sim = intellwheels(floor="corner", seed="1")`. The arguments are those of `Rig` other than `logs`;
    `python -m pydoc intellwheels_experiments.testing.rig` describes them. A test may start several worlds. Relative
    paths start at the folder of the test file. All processes end with the test. If it fails, its report shows what they
    printed last.
    """
    from intellwheels_experiments.testing.rig import Rig  # noqa: PLC0415 - heavy, see above

    rigs = request.node.stash.setdefault(RIGS, [])
    with ExitStack() as stack:

        def start(**options: Any) -> Rig:
            folder = options.pop("folder", request.path.parent)
            rig = Rig(tmp_path / f"intellwheels-{len(rigs) + 1}", folder=folder, **options)
            # Noted before it starts, so that a failed start is reported too.
            rigs.append(rig)
            return stack.enter_context(rig)

        yield start


# The old form of a hook wrapper, as a user's pytest may be older than ours.
@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Add what the processes printed to the report of a failed test."""
    outcome = yield
    report = outcome.get_result()
    if report.failed:
        for rig in item.stash.get(RIGS, []):
            report.sections.extend((f"intellwheels: {title}", text) for title, text in rig.sections())
