"""The examples in other languages, built in a cache outside the checkout, each as a command to start.

`$XDG_CACHE_HOME/intellwheels-build` (else `~/.cache/...`) keeps what takes minutes: Zenoh's own crates, the bridge,
npm's packages. Without it, or without a tool chain, a test says so and is skipped; with REQUIRE_LANGUAGES=1 what is
not there is built, and a missing tool chain fails.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import NoReturn

import pytest

from tests.e2e.stage import Stage, free_port

EXAMPLES = Path(__file__).parents[2] / "agents" / "examples" / "other_languages"
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "intellwheels-build"
REQUIRED = os.environ.get("REQUIRE_LANGUAGES") == "1"
BUILD_LIMIT = 3600.0 if REQUIRED else 120.0
BRIDGE = "zenoh-bridge-remote-api"
BRIDGE_VERSION = "1.10.2"
"""Of the same minor version as zenoh-ts: they have a protocol of their own."""

Started = Callable[[Stage], AbstractContextManager[list[str]]]
"""Makes the command that leads to a stage's endpoint, with `{name}` in it; what it needs runs within the `with`."""


def lacking(why: str) -> NoReturn:
    if REQUIRED:
        pytest.fail(why)
    pytest.skip(why)


def tool(name: str) -> str:
    return shutil.which(name) or lacking(f"no {name} here")


def built_folder(language: str) -> Path:
    """Return the folder of the cache with the example's sources as they are now; those unchanged stay as old."""
    source, folder = EXAMPLES / language, CACHE / language
    for path in source.rglob("*"):
        copy = folder / path.relative_to(source)
        if path.is_file() and {"target", "node_modules"}.isdisjoint(path.parts):
            copy.parent.mkdir(parents=True, exist_ok=True)
            if not copy.exists() or copy.read_bytes() != path.read_bytes():
                shutil.copyfile(path, copy)
    return folder


def build(command: Sequence[str], folder: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "CARGO_TARGET_DIR"}
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=BUILD_LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        lacking(f"{' '.join(command)}: not done in {BUILD_LIMIT:.0f} s")
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout[-4000:]}{done.stderr[-4000:]}"


def need(path: Path) -> bool:
    """Return whether something must be built first, which only happens where languages are required."""
    if path.exists():
        return False
    if not REQUIRED:
        pytest.skip(f"no {path.name} in the build cache; REQUIRE_LANGUAGES=1 builds it, in minutes")
    return True


def direct(*command: str) -> Started:
    @contextmanager
    def start(stage: Stage) -> Iterator[list[str]]:
        yield [*command, "{name}", stage.endpoint]

    return start


def python() -> Started:
    return direct(sys.executable, str(EXAMPLES / "python" / "avoid.py"))


def rust() -> Started:
    cargo = tool("cargo")
    program = CACHE / "rust" / "target" / "debug" / "avoid"
    need(program)
    build([cargo, "build", "--jobs", "1"], built_folder("rust"))
    return direct(str(program))


def typescript() -> Started:
    node, npm = tool("node"), tool("npm")
    modules = CACHE / "typescript" / "node_modules"
    missing = need(modules / "@eclipse-zenoh" / "zenoh-ts")
    bridge = _bridge()
    folder = built_folder("typescript")
    if missing:
        build([npm, "install", "--no-audit", "--no-fund", "--no-package-lock"], folder)
    build([npm, "run", "build"], folder)
    # `npm start` passes no signal on before it ends itself, so its words are taken and not npm.
    flags = ["--experimental-websocket", "--experimental-wasm-modules"]
    command = [node, *flags, str(folder / "avoid.js"), "{name}"]

    @contextmanager
    def start(stage: Stage) -> Iterator[list[str]]:
        port = free_port()
        words = ["--no-multicast-scouting", "--listen", "tcp/127.0.0.1:0", "--connect", stage.endpoint]
        process = subprocess.Popen(
            [bridge, *words, "--ws-port", f"127.0.0.1:{port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            stage.wait(lambda: _listens(port) or None, "bridge")
            yield [*command, f"ws/127.0.0.1:{port}"]
        finally:
            process.kill()
            process.wait(timeout=10.0)

    return start


def _bridge() -> str:
    found = shutil.which(BRIDGE)
    if found:
        return found
    root = CACHE / "bridge"
    if need(root / "bin" / BRIDGE):
        build([tool("cargo"), "install", BRIDGE, "--version", BRIDGE_VERSION, "--debug", "--root", str(root)], CACHE)
    return str(root / "bin" / BRIDGE)


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(1.0)
        return probe.connect_ex(("127.0.0.1", port)) == 0
