"""A scene without a browser: viser on a free port of the loopback."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import viser


@pytest.fixture(scope="session")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def scene(server: viser.ViserServer) -> viser.SceneApi:
    server.scene.reset()
    return server.scene
