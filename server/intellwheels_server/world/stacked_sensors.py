"""The sensors of many worlds, sampled in one call for each kind.

A block that has the methods of `StackableBlock` is sampled by one kernel in all worlds. Any other is sampled in one
world after the other, which gives the same samples and takes longer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.rounded_readings import round_readings
from intellwheels_server.world.sensors import SensorPlan
from intellwheels_server.world.sensors.kind import Array, Block, ManyViews, StackableBlock, View


@dataclass(frozen=True)
class _Together:
    """The blocks of one kind as arrays, whose first axis is the world."""

    kind: type[StackableBlock]
    arrays: tuple[Array, ...]

    def take(self, ticks: Ints, views: ManyViews, samples: Floats, first: int, end: int) -> None:
        self.kind.take_many(ticks, views, self.arrays, samples, first, end)

    def replaced(self, blocks: Mapping[int, Block]) -> _Together:
        arrays = tuple(array.copy() for array in self.arrays)
        for world, block in blocks.items():
            own = block.stackable() if isinstance(block, StackableBlock) else None
            assert own is not None  # noqa: S101 - its sensors are laid out as those of the others
            for array, new in zip(arrays, own, strict=True):
                array[world] = new
        return _Together(self.kind, arrays)


@dataclass(frozen=True)
class _OneByOne:
    """The blocks of one kind, one for each world."""

    blocks: tuple[Block, ...]

    def take(self, ticks: Ints, views: ManyViews, samples: Floats, first: int, end: int) -> None:
        for world in range(first, end):
            view = View(views.numbers[world], views.parts[world], views.part_start, views.walls, views.period)
            self.blocks[world].take(int(ticks[world]), view, samples[world])

    def replaced(self, blocks: Mapping[int, Block]) -> _OneByOne:
        return _OneByOne(tuple(blocks.get(world, block) for world, block in enumerate(self.blocks)))


_Stack: TypeAlias = _Together | _OneByOne


@dataclass(frozen=True)
class StackedSensors:
    """All sensors of many worlds.

    Attributes:
        stacks: The blocks of each kind.
        spans: int64[worlds * sensors, 2], places of samples among those of all worlds, as `SensorPlan.spans`.
        sensors: The number of sensors of a world.
    """

    stacks: tuple[_Stack, ...]
    spans: Ints
    sensors: int

    def take(self, ticks: Ints, views: ManyViews, samples: Floats, first: int, end: int) -> None:
        """Store the samples that are due in some worlds, rounded, exactly as `sense` does in each.

        Args:
            ticks: int64[worlds], the tick of each world.
            views: The worlds.
            samples: float64[worlds, ...], C-contiguous, written.
            first: The first world.
            end: One past the last.
        """
        for stack in self.stacks:
            stack.take(ticks, views, samples, first, end)
        if self.sensors:
            round_readings(self.spans[first * self.sensors : end * self.sensors], samples.reshape(-1))

    def replaced(self, plans: Mapping[int, SensorPlan]) -> StackedSensors:
        """Return these sensors with those of some worlds replaced, laid out as before: see `layout_of`."""
        stacks = tuple(
            stack.replaced({world: plan.blocks[k] for world, plan in plans.items()})
            for k, stack in enumerate(self.stacks)
        )
        return StackedSensors(stacks, self.spans, self.sensors)


def layout_of(plan: SensorPlan) -> tuple[object, ...]:
    """Return what plans must have in common to be stacked: the places of all samples, and the shapes of all arrays."""
    blocks: list[object] = []
    for block in plan.blocks:
        own = block.stackable() if isinstance(block, StackableBlock) else None
        blocks.append((type(block), None if own is None else tuple(array.shape for array in own)))
    return plan.spans.tobytes(), plan.memory.tobytes(), tuple(blocks)


def stack_sensors(plans: Sequence[SensorPlan], size: int) -> StackedSensors:
    """Return the sensors of many worlds, one plan for each, all of the same layout.

    Args:
        plans: At least one.
        size: The length of the samples of a world.
    """
    offsets = size * np.arange(len(plans), dtype=np.int64)
    spans = (plans[0].spans[None] + offsets[:, None, None]).reshape(-1, 2)
    stacks = tuple(_stacked([plan.blocks[k] for plan in plans]) for k in range(len(plans[0].blocks)))
    return StackedSensors(stacks, spans, len(plans[0].spans))


def _stacked(blocks: Sequence[Block]) -> _Stack:
    arrays = [block.stackable() for block in blocks if isinstance(block, StackableBlock)]
    ready = [own for own in arrays if own is not None]
    if len(ready) < len(blocks):
        return _OneByOne(tuple(blocks))
    first = blocks[0]
    assert isinstance(first, StackableBlock)  # noqa: S101 - they all are
    return _Together(type(first), tuple(np.stack(column) for column in zip(*ready, strict=True)))
