"""A browser that has nothing but a camera."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any


class FakeCamera:
    """A browser: it keeps what it is told as a page does, and reports it when asked to."""

    def __init__(self, *, width: int = 1280, height: int = 800) -> None:
        self.calls: list[Any] = []
        self.camera: Any = SimpleNamespace(
            position=(4.0, -6.0, 5.0), look_at=(0.0, 0.0, 0.0), up_direction=(0.0, 0.0, 1.0), fov=0.8, near=0.1,
            far=1000.0, image_width=width, image_height=height, aspect=width / max(height, 1),
            on_update=self._hear,
        )  # fmt: skip

    def _hear(self, call: Any) -> Any:
        self.calls.append(call)
        return call

    @contextmanager
    def atomic(self) -> Iterator[None]:
        yield

    def report(self, **changes: Any) -> None:
        """The page says where its camera is."""
        for name, value in changes.items():
            setattr(self.camera, name, value)
        for call in self.calls:
            asyncio.run(call(self.camera))

    def resize(self, width: int, height: int) -> None:
        self.report(image_width=width, image_height=height, aspect=width / max(height, 1))
