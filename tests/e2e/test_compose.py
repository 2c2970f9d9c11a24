"""The composition: Figure 6 again, each agent in a container of its own."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import tomllib
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from intellwheels_maps import scene
from tests.e2e.stage import Peer, Stage, free_port
from tests.viewer.browser import opened

ROOT = Path(__file__).parents[2]
WORLD = "composed"
BASE = os.environ.get("BASE_IMAGE", "python:3.12-slim")


def composition() -> dict[str, Any]:
    loaded = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    assert isinstance(loaded, dict)
    return loaded


def options_of(words: list[str], name: str) -> list[str]:
    return [words[k + 1] for k, word in enumerate(words) if word == name]


def test_cast_of_the_composition_is_that_of_the_scene() -> None:
    services = composition()["services"]
    cast = {}
    for service in services.values():
        if service.get("entrypoint", [""])[0] == "iw-agent":
            words = service["command"]
            (name,) = options_of(words, "--name")
            pairs = dict(option.split("=", 1) for option in options_of(words, "--option"))
            cast[name] = (
                service["entrypoint"][1], options_of(words, "--robot")[0], options_of(words, "--place")[0], pairs
            )  # fmt: skip
    wanted = {
        one.name: (one.mind, one.robot, one.place, {option.name: option.value for option in one.option})
        for one in scene("figure6").cast
    }
    assert cast == wanted
    assert options_of(services["simulator"]["command"], "--scene") == ["figure6"]


def test_services_are_those_of_the_documents_and_reachable_from_this_machine_only() -> None:
    services = composition()["services"]
    scene = {"router", "simulator", "door", "table", "chair", "chair-rear", "chair-mid", "viewer"}
    cluster = {name for name, service in services.items() if service.get("profiles") == ["cluster"]}
    assert (set(services) - cluster, cluster) == (scene, {"scheduler", "worker"})
    ports = [port for service in services.values() for port in service.get("ports", [])]
    assert ports == [
        "${BIND:-127.0.0.1}:${PORT:-7447}:7447",
        "${BIND:-127.0.0.1}:${VIEW_PORT:-8080}:8080",
        "${BIND:-127.0.0.1}:${CLUSTER_PORT:-8786}:8786",
    ]
    assert all(service["init"] and service["read_only"] for service in services.values())


def test_containers_have_no_rights_and_bounds() -> None:
    for service in composition()["services"].values():
        assert service["cap_drop"] == ["ALL"]
        assert service["security_opt"] == ["no-new-privileges:true"]
        assert (service["mem_limit"], service["pids_limit"]) == ("${MEMORY:-1g}", 256)
        assert service["restart"] == "unless-stopped"


@pytest.mark.parametrize(("lock", "extras"), [("requirements", {"all", "cluster"}), ("build", set())])
def test_lock_has_every_requirement_with_hashes_and_no_address(lock: str, extras: set[str]) -> None:
    text = (ROOT / "server" / f"{lock}.lock").read_text()
    assert "://" not in text
    entries = text.replace("\\\n", " ").splitlines()
    assert all(re.search(r" --hash=sha256:[0-9a-f]{64}", entry) for entry in entries)
    locked = [Requirement(entry.partition(" --hash")[0]) for entry in entries]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    wanted = project["build-system"]["requires"] if lock == "build" else required(project["project"], extras)
    for wish in map(Requirement, wanted):
        found = [one for one in locked if canonicalize_name(one.name) == canonicalize_name(wish.name)]
        assert found, f"{wish} is not in {lock}.lock; CONTRIBUTING.md says how to make it again"
        for one in found:
            (version,) = one.specifier
            assert wish.specifier.contains(version.version), f"{one} does not fit {wish}"


def required(project: dict[str, Any], extras: set[str]) -> list[str]:
    """Return the requirements of some extras, and of those that they include."""
    found = list(project["dependencies"])
    for extra in extras:
        for wish in project["optional-dependencies"][extra]:
            own = Requirement(wish)
            found += required(project, own.extras) if own.name == project["name"] else [wish]
    return found


def test_base_image_may_have_a_digest() -> None:
    if shutil.which("docker") is None:
        pytest.skip("no docker command here")
    image = f"python:3.12-slim@sha256:{'0' * 64}"
    words = ["docker", "compose", "config", "--format", "json"]
    done = subprocess.run(words, cwd=ROOT, env={**os.environ, "BASE_IMAGE": image}, capture_output=True, text=True,
                          timeout=60.0, check=False)  # fmt: skip
    if done.returncode != 0 and "compose" in done.stderr and "services" not in done.stderr:
        pytest.skip("docker has no compose plugin here")
    assert json.loads(done.stdout)["services"]["router"]["build"]["args"]["BASE_IMAGE"] == image


def why_not() -> str | None:
    """Return why no composition can be started here, or None."""
    if shutil.which("docker") is None:
        return "no docker command here"
    for words, why in (
        (["docker", "info"], "no docker engine answers here"),
        (["docker", "compose", "version"], "docker has no compose plugin here"),
    ):
        if subprocess.run(words, capture_output=True, timeout=30, check=False).returncode != 0:
            return why
    found = subprocess.run(["docker", "image", "inspect", BASE], capture_output=True, timeout=30, check=False)
    if found.returncode != 0 and "BASE_IMAGE" in os.environ:
        return f"no image {BASE} here"
    if found.returncode != 0:
        pulled = subprocess.run(["docker", "pull", "-q", BASE], capture_output=True, timeout=300, check=False)
        return None if pulled.returncode == 0 else f"no image {BASE} here, and no registry gives it"
    return None


class Composed:
    """A composition of its own name, port and world."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        port = free_port()
        stage.endpoint = f"tcp/127.0.0.1:{port}"
        project = f"iw-test-{os.getpid()}"  # two runs of the suite at once are none of each other's business
        self.page = f"http://127.0.0.1:{(view := free_port())}"
        self.environment = {
            **os.environ, "PORT": str(port), "VIEW_PORT": str(view), "WORLD": stage.world, "BASE_IMAGE": BASE,
            "BUILD_NETWORK": "host", "COMPOSE_PROJECT_NAME": project, "IMAGE": project,
        }  # fmt: skip

    def __call__(self, *words: str, timeout: float = 120.0, codes: tuple[int, ...] = (0,)) -> str:
        done = subprocess.run(
            ["docker", "compose", *words],
            cwd=ROOT,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        assert done.returncode in codes, done.stdout + done.stderr + self.logs()
        return done.stdout

    def logs(self) -> str:
        found = subprocess.run(
            ["docker", "compose", "logs", "--no-color", "--tail", "30"],
            cwd=ROOT,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=60.0,
            check=False,
        )
        return found.stdout

    def kill(self, service: str) -> None:
        """Kill all that runs in a container, as a crash would, and wait until docker has started it again."""
        before = self.restarts(service)
        # The container may be gone before its shell ends, which is a kill too.
        self("exec", "-T", service, "sh", "-c", "kill -9 -1 || true", codes=(0, 128 + signal.SIGKILL))
        self.stage.wait(lambda: self.restarts(service) > before or None, f"another start of {service}")

    def restarts(self, service: str) -> int:
        """Return how often docker has started a container of a service again."""
        container = self("ps", "--all", "--quiet", service).strip()
        words = ["docker", "inspect", "--format", "{{.RestartCount}}", container]
        return int(subprocess.run(words, capture_output=True, text=True, timeout=30.0, check=True).stdout)


@pytest.fixture
def composed(tmp_path: Path) -> Iterator[Composed]:
    reason = why_not()
    if reason is not None:
        if os.environ.get("REQUIRE_DOCKER"):
            pytest.fail(reason)
        pytest.skip(reason)
    with Stage(tmp_path, WORLD) as stage:
        compose = Composed(stage)
        try:
            yield compose
        finally:
            # The image too: layers stay in the builder's cache, but each run would leave one without a name.
            compose("down", "--timeout", "3", "--remove-orphans", "--rmi", "all")


def all_there(peer: Peer, *names: str) -> None:
    for name in names:
        peer.entity(name, lambda _: True)


@pytest.mark.docker
def test_figure_6_in_containers_from_building_to_down(composed: Composed) -> None:
    composed("build", "router", timeout=600.0)
    composed("up", "--detach", "--wait", timeout=180.0)
    cast = ("chair1", "chair2", "chair3", "door", "table")
    copies = ("chair3-2", "chair3-3", "chair3-4", "chair3-5")
    five = ("up", "--detach", "--wait", "--scale", "chair=5", "--no-recreate")
    assert "compiling kernels" not in composed("logs", "simulator")  # the image brings them
    with urllib.request.urlopen(composed.page, timeout=10.0) as answer:
        assert b"<html" in answer.read()
    # A browser on this machine. A program without `Origin` could not start the run.
    with opened(int(composed.page.rpartition(":")[2]), origin=composed.page), composed.stage.peer() as peer:
        ended = peer.event("ended", timeout=120.0)
        assert str(ended["Text"]).startswith("reached")
        composed(*five, timeout=180.0)
        all_there(peer, *cast, *copies)
        composed.stage.agent("host", "drive", "--position", "10.5,4.8,0")  # all free places are taken
        all_there(peer, "host")
        composed.stage.signal("host", signal.SIGTERM)
        assert composed.stage.exit("host") == 0
        run = peer.clock()["Run"]
        composed.kill("simulator")
        composed.stage.wait(lambda: _again(peer, run, (*cast, *copies)), "a new run with everybody in it", timeout=90.0)
    composed.kill("router")
    composed(*five, timeout=180.0)
    with composed.stage.peer() as peer:
        all_there(peer, *cast, *copies)


def _again(peer: Peer, run: str, names: tuple[str, ...]) -> bool | None:
    """Return True once another run has all of these in it; while the simulator is away nobody answers."""
    clocks = peer.ask("clock")
    return True if clocks and clocks[0]["Run"] != run and set(names) <= set(peer.entities()) else None
