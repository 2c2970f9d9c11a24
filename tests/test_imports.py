"""Who may import whom. Rooms meet on the wire, pure files stay pure, and zenoh has few doors."""

from __future__ import annotations

import ast
import functools
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.commands import MODULES, SCRIPTS, file_of

ROOT = Path(__file__).parent.parent
PACKAGES = {
    "intellwheels_schemas": ROOT / "schemas",
    "intellwheels_maps": ROOT / "maps",
    "intellwheels_server": ROOT / "server",
    "intellwheels_gym": ROOT / "server",
    "intellwheels_agents": ROOT / "agents",
    "intellwheels_experiments": ROOT / "agents",
    "intellwheels_viewer": ROOT / "viewer",
}
MAY_IMPORT = {
    "intellwheels_schemas": set[str](),
    "intellwheels_maps": {"intellwheels_schemas"},
    "intellwheels_server": {"intellwheels_schemas", "intellwheels_maps"},
    # The one package in which the world and minds meet in a process: nothing imports it.
    "intellwheels_gym": {
        "intellwheels_schemas",
        "intellwheels_maps",
        "intellwheels_server",
        "intellwheels_agents",
        "intellwheels_experiments",
    },
    "intellwheels_agents": {"intellwheels_schemas", "intellwheels_maps"},
    "intellwheels_experiments": {"intellwheels_schemas", "intellwheels_maps"},
    "intellwheels_viewer": {"intellwheels_schemas", "intellwheels_maps"},
}
KNOWS_ZENOH = {
    "schemas/intellwheels_schemas/link.py",
    "schemas/intellwheels_schemas/own_rights.py",
    "schemas/intellwheels_schemas/router_link.py",
    "schemas/intellwheels_schemas/simulator_query.py",
    "schemas/intellwheels_schemas/zenoh_inbox.py",
    "server/intellwheels_server/service/claim_watch.py",
    "server/intellwheels_server/service/simulator_peer.py",
    "agents/intellwheels_agents/agent_peer.py",
    "agents/intellwheels_agents/crew_peer.py",
    "agents/intellwheels_agents/simulator_session.py",
    "agents/intellwheels_agents/joystick/joystick_peer.py",
    "agents/intellwheels_agents/ros_gateway/ros_node.py",
    "agents/intellwheels_experiments/run/world_watch.py",
    "agents/intellwheels_experiments/conformance/scripted_simulator.py",
    "viewer/intellwheels_viewer/viewer_peer.py",
}
"""The files that talk to the network: one per room, the probe of `iw-check-agent` and the joystick."""

# The entries of the checkout that a user sees; papers and dot files beside the rooms.
TOP_LEVEL = {
    "pyproject.toml", "docker-compose.yml", "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE",
    "schemas", "server", "agents", "viewer", "maps", "tests",
}  # fmt: skip


def sources() -> Iterator[tuple[str, Path]]:
    for package, room in PACKAGES.items():
        for path in sorted((room / package).rglob("*.py")):
            yield package, path


@functools.cache
def imported(path: Path) -> frozenset[str]:
    """Return what a source file imports, also inside functions: modules, and what is taken from them."""
    return frozenset(_imports(path))


def _imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(), str(path))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module or ""
            yield from (f"{node.module}.{name.name}" for name in node.names)


FILES = list(sources())
OPENERS = {
    "intellwheels_agents.ciber_gateway.ciber_process",
    "intellwheels_agents.ciber_gateway.reception",
    "intellwheels_agents.ciber_gateway.robot_client",
    "intellwheels_agents.joystick.joystick_options",
    "intellwheels_agents.record_gateway.log_source",
    "intellwheels_agents.record_gateway.panel_driver",
    "intellwheels_agents.record_gateway.record_process",
    "intellwheels_agents.record_gateway.world_source",
    "intellwheels_server.service.arrival_reader",
    "intellwheels_server.service.main_loop",
    "intellwheels_schemas.present",
    "intellwheels_server.server_options",
    "intellwheels_experiments.run.usage_checks",
    "intellwheels_experiments.testing.rig",
    "intellwheels_viewer.router_rights",
    "intellwheels_viewer.viewer_service",
    "intellwheels_experiments.batch.run_worker",
    "intellwheels_agents.ros_gateway.gateway_process",
    "intellwheels_agents.ros_gateway.watched_chair",
    "intellwheels_agents.ros_gateway.world_link",
}
"""Files that do a command's work or read an inbox, beside those of the commands themselves."""


@pytest.mark.parametrize("package", PACKAGES)
def test_room_imports_the_contract_and_no_other_room(package: str) -> None:
    guilty = {}
    for path in (path for inside, path in FILES if inside == package):
        others = {name.split(".")[0] for name in imported(path)} & PACKAGES.keys()
        if not others <= MAY_IMPORT[package] | {package}:
            guilty[str(path.relative_to(ROOT))] = others
    assert guilty == {}


@pytest.mark.parametrize(
    ("package", "never"),
    [
        ("intellwheels_server.world", {"intellwheels_server.log", "intellwheels_server.service"}),
        ("intellwheels_server.log", {"intellwheels_server.service"}),
    ],
)
def test_inner_package_never_imports_the_outer_ones(package: str, never: set[str]) -> None:
    inside = [path for _, path in FILES if dotted(path) == package or dotted(path).startswith(f"{package}.")]
    assert inside
    guilty = {
        dotted(path): name
        for path in inside
        for name in imported(path)
        if any(name == other or name.startswith(f"{other}.") for other in never)
    }
    assert guilty == {}


def test_zenoh_is_known_at_the_doors_only() -> None:
    doors = {
        str(path.relative_to(ROOT)) for _, path in FILES if any(n.split(".")[0] == "zenoh" for n in imported(path))
    }
    assert doors <= KNOWS_ZENOH


def dotted(path: Path) -> str:
    """Return a source file's import name."""
    room = next(room for package, room in PACKAGES.items() if path.is_relative_to(room / package))
    parts = path.relative_to(room).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_pure_files_do_not_import_the_doors() -> None:
    doors = {dotted(ROOT / door) for door in KNOWS_ZENOH}
    # A command opens its room's door: that is its work.
    openers = doors | OPENERS | {file_of(name) for name in SCRIPTS}
    guilty = {
        dotted(path): found
        for _, path in FILES
        if dotted(path) not in openers and (found := doors.intersection(imported(path)))
    }
    assert guilty == {}


@pytest.mark.process
def test_harness_needs_neither_numpy_nor_numba_nor_shapely_nor_viser() -> None:
    agents = ", ".join(file_of(name) for name in SCRIPTS if MODULES[name].startswith("intellwheels_agents"))
    program = (
        "import sys\n"
        "for name in ('numpy', 'numba', 'shapely', 'viser', 'pygame', 'serial'):\n"
        "    sys.modules[name] = None\n"
        f"import intellwheels_experiments.__main__, intellwheels_schemas.link, {agents}\n"
        "import importlib, pkgutil, intellwheels_agents.minds\n"
        "for mind in pkgutil.iter_modules(intellwheels_agents.minds.__path__):\n"
        "    importlib.import_module(f'intellwheels_agents.minds.{mind.name}')\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.process
def test_nothing_is_added_at_the_top_level() -> None:
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    if listed.returncode != 0:
        pytest.skip("no checkout of git")
    entries = {line.split("/")[0] for line in listed.stdout.splitlines()}
    assert {entry for entry in entries if not entry.startswith(".")} <= TOP_LEVEL
