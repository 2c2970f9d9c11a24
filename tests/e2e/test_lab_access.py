"""The router of a lab enforces the table of KEYS.md, key by key, for each role, and lets nobody else in."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.access_rules import ACCESS, OVERSEES, TOKEN_ROLES
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.files import write_file
from intellwheels_schemas.identity_file import read_identity, write_secret
from intellwheels_schemas.keys import AGENT_VERBS, VERBS
from intellwheels_schemas.lab_rules import LAB_ROLES, NO_AGENTS
from intellwheels_schemas.messages import Identity, Lab, LabRole, May, Pause
from intellwheels_server.service import lab_keys
from intellwheels_viewer import viewer_peer
from intellwheels_viewer.steering import Refusal
from tests.e2e.stage import DEADLINE, Stage, run

pytestmark = pytest.mark.process

OWN, OTHER, INSTANCE = "a1-x", "b1-x", "0123456789abcdef"
STRANGER = "stranger"
"""An operator of another world."""
ROLES = [role for role in LAB_ROLES if role != "simulator"]
LAB = Lab(
    format="iw.v1",
    name="test",
    identity=(
        Identity(name="simulator", may=(May(role="simulator"), May(role="simulator", world="other"))),
        *(Identity(name=role, may=(May(role=role, agents=() if role in NO_AGENTS else ("a1-*",)),)) for role in ROLES),
        Identity(name="simulator2", may=(May(role="simulator", world="other2"),)),
        Identity(
            name="student2",
            may=(
                May(role="agent", world="other2", agents=("a2-*",)),
                May(role="mind", world="other2", agents=("real2",)),
                May(role="viewer", world="other2"),
            ),
        ),
        Identity(name="bridge2", may=(May(role="bridge", world="other2", agents=("real2",)),)),
        Identity(name=STRANGER, may=(May(role="operator", world="other", agents=("*",)),)),
    ),
)


def keys_of(channel: str, agent: str = OWN) -> list[str]:
    """Return keys of a channel, with names in the place of what varies."""
    key = CHANNELS[channel].key.replace("<agent>", agent).replace("<part>", "0").replace("<crew>", "a1-x")
    verbs = [verb for verb in VERBS if (verb in AGENT_VERBS) == (channel == "ctl_agent")]
    return [f"iw/v1/main/{key.replace('<verb>', verb)}" for verb in (verbs if "<verb>" in key else [""])]


def writes(role: str, channel: str) -> bool:
    return role in LAB_ROLES and ACCESS[channel].get(role, "") in ("writes", "both")


def reads(role: str, channel: str) -> bool:
    return role in LAB_ROLES and ACCESS[channel].get(role, "") in ("reads", "both")


PUTS = [name for name, channel in CHANNELS.items() if channel.kind == "put"]
NAMED = [name for name in PUTS if "<agent>" in CHANNELS[name].key]


class Heard:
    """The keys of what arrived."""

    def __init__(self) -> None:
        self.keys: set[str] = set()
        self._changed = threading.Condition()

    def store(self, sample: zenoh.Sample) -> None:
        with self._changed:
            self.keys.add(str(sample.key_expr))
            self._changed.notify()

    def wait(self, keys: set[str]) -> None:
        """Wait until at least these keys have arrived."""
        with self._changed:
            self._changed.wait_for(lambda: self.keys >= keys, DEADLINE)


class Network:
    """A router with rules, and sessions of its identities."""

    def __init__(self, stack: ExitStack, stage: Stage, folder: Path) -> None:
        self._stack, self.stage = stack, stage
        self.endpoint, self.folder = stage.endpoint, folder
        file = folder / "lab.xml"
        file.write_text(write_file(LAB))
        assert lab_keys.main(["keys", "--lab", str(file)]) == 0
        for identity in LAB.identity:
            out = str(folder / f"{identity.name}.iwid")
            words = ["invite", identity.name, "--lab", str(file), "--out", out, "--connect", self.endpoint]
            assert lab_keys.main(words) == 0
        module = "intellwheels_server.service.router"
        stage.line(stage.start("router", module, "--lab", str(file), "--listen", self.endpoint), "ready")
        self.simulator = self.session("simulator")
        self.heard = Heard()
        self.simulator.declare_subscriber("iw/v1/main/**", self.heard.store)
        for world in ("main", "other"):
            for key in ("map", "clock", "event", "body/*", "state/*", "join/*", "leave/*", "ctl/*", "ctl/*/*",
                        "crew/*/join", "crew/*/leave"):  # fmt: skip
                self.simulator.declare_queryable(f"iw/v1/{world}/{key}", self._reply)
        self.sessions = {name: self.session(name) for name in (*ROLES, STRANGER)}
        # From here on the router knows what the simulator declared.
        assert self.answers(self.simulator, "iw/v1/other/map")

    def session(self, name: str) -> zenoh.Session:
        identity = self.folder / f"{name}.iwid"
        session = link.open_session(
            link.Link(connect=(self.endpoint,), identity=identity), threading.Event(), timeout=DEADLINE
        )
        assert session is not None
        return self._stack.enter_context(session)

    def settle(self, name: str) -> None:
        """Return when the router and the simulator have taken everything that a session sent before."""
        world = "other" if name == STRANGER else "main"
        # Every role reads the clock.
        assert self.answers(self.sessions[name], f"iw/v1/{world}/clock"), f"{name} may read the clock"

    @staticmethod
    def answers(session: zenoh.Session, key: str) -> bool:
        return any(reply.ok is not None for reply in session.get(key, timeout=DEADLINE))

    @staticmethod
    def _reply(query: zenoh.Query) -> None:
        with query:
            query.reply(str(query.key_expr), b"{}")


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Network]:
    folder = tmp_path_factory.mktemp("lab")
    with Stage(folder, "lab") as stage, ExitStack() as stack:
        yield Network(stack, stage, folder)


@pytest.mark.parametrize("role", [*ROLES, STRANGER])
@pytest.mark.parametrize("declares", [True, False], ids=["publisher", "put"])
def test_role_puts_on_its_own_keys_only(network: Network, role: str, declares: bool) -> None:
    network.heard.keys.clear()
    session = network.sessions[role]
    keys = sorted({key for channel in PUTS for agent in (OWN, OTHER) for key in keys_of(channel, agent)})
    if declares:
        publishers: list[Any] = [session.declare_publisher(key) for key in keys]
        network.settle(role)
        for publisher in publishers:
            publisher.put(b"{}")
            publisher.undeclare()
    else:
        for key in keys:
            session.put(key, b"{}")
    network.settle(role)
    expected = {key for channel in PUTS if writes(role, channel) for key in keys_of(channel)}
    network.heard.wait(expected)
    network.settle(role)
    assert network.heard.keys == expected


@pytest.mark.parametrize("role", [*ROLES, STRANGER])
def test_role_hears_what_it_may_read_and_nothing_else(network: Network, role: str) -> None:
    heard = Heard()
    expected = {key for channel in PUTS if reads(role, channel) for key in keys_of(channel)}
    if role in OVERSEES:
        expected |= {key for channel in NAMED if reads(role, channel) for key in keys_of(channel, OTHER)}
    last = {f"iw/v1/{'other' if role == STRANGER else 'main'}/clock"}
    session = network.sessions[role]
    wanted = [*{key for channel in PUTS for agent in (OWN, OTHER) for key in keys_of(channel, agent)}]
    subscribers: list[Any] = [session.declare_subscriber(key, heard.store) for key in sorted(wanted)]
    if role == STRANGER:
        subscribers.append(session.declare_subscriber("iw/v1/other/clock", heard.store))
    subscribers += [session.declare_subscriber(f"iw/v1/main/{key}", lambda _: None) for key in ("**", "in/**")]
    try:
        network.settle(role)
        for key in sorted(wanted):
            network.simulator.put(key, b"{}")
        network.simulator.put("iw/v1/other/clock", b"{}")
        heard.wait(expected | last)
        network.settle(role)
    finally:
        for subscriber in subscribers:
            subscriber.undeclare()
    assert heard.keys - {"iw/v1/other/clock"} == expected


@pytest.mark.parametrize("role", [*ROLES, STRANGER])
def test_role_queries_what_it_may_and_nothing_else(network: Network, role: str) -> None:
    for name, channel in CHANNELS.items():
        if channel.kind == "token" or (channel.kind == "put" and not channel.get):
            continue
        may = reads(role, name) if channel.get else writes(role, name)
        for key in keys_of(name):
            allowed = may and (role != "viewer" or name != "ctl_agent" or "/take/" in key)
            assert network.answers(network.sessions[role], key) is allowed, key
        if "<agent>" in channel.key:
            oversees = channel.get and role in OVERSEES
            for key in keys_of(name, OTHER):
                assert network.answers(network.sessions[role], key) is (may and oversees), key


def test_everything_that_one_session_sends_in_a_burst_arrives(network: Network) -> None:
    session, heard = network.sessions["agent"], []
    store: Any = zenoh.handlers.Callback(lambda sample: heard.append(str(sample.key_expr)), indirect=False)
    subscriber: Any = network.simulator.declare_subscriber("iw/v1/main/in/**", store)
    chairs = [f"a1-{number}" for number in range(15)]
    burst = [f"iw/v1/main/in/{chair}/actions" for chair in chairs] + [f"iw/v1/main/in/{OWN}/say"] * 2
    try:
        network.settle("agent")
        for key in burst * 3:
            session.put(key, b"{}")
        network.settle("agent")
    finally:
        subscriber.undeclare()
    assert heard == burst * 3
    joins = [session.get(f"iw/v1/main/join/{chair}", timeout=DEADLINE) for chair in chairs]
    assert all(any(reply.ok is not None for reply in replies) for replies in joins)


@pytest.mark.parametrize("role", [*ROLES, STRANGER])
def test_role_declares_the_tokens_of_its_agents_only(network: Network, role: LabRole) -> None:
    session = network.sessions[role]
    tokens = [f"in/{agent}/alive/{kind}/{INSTANCE}" for agent in (OWN, OTHER) for kind in ("both", "mind", "body")]
    tokens += ["alive", f"alive/{INSTANCE}/{INSTANCE}"]
    declared: list[Any] = [session.liveliness().declare_token(f"iw/v1/main/{token}") for token in tokens]
    try:
        network.settle(role)
        replies = network.simulator.liveliness().get("iw/v1/main/**", timeout=DEADLINE)
        seen = {str(reply.ok.key_expr) for reply in replies if reply.ok is not None}
    finally:
        for token in declared:
            token.undeclare()
        network.settle(role)
    assert seen == {f"iw/v1/main/in/{OWN}/alive/{kind}/{INSTANCE}" for kind in TOKEN_ROLES.get(role, ())}


@pytest.mark.parametrize("role", [*ROLES, STRANGER])
def test_role_answers_no_query_in_the_name_of_the_simulator(network: Network, role: str) -> None:
    def lie(query: zenoh.Query) -> None:
        with query:
            query.reply(str(query.key_expr), b"lie")

    session = network.sessions[role]
    lies: list[Any] = [session.declare_queryable(f"iw/v1/main/{key}", lie) for key in ("join/*", "map", "clock", "**")]
    try:
        network.settle(role)
        replies = network.simulator.get(
            "iw/v1/main/map", target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE,
            timeout=DEADLINE,
        )  # fmt: skip
        assert [reply.ok.payload.to_bytes() for reply in replies if reply.ok is not None] == [b"{}"]
    finally:
        for one in lies:
            one.undeclare()


@pytest.mark.parametrize("who", ["nobody", "a wrong password", "an identity of another lab"])
def test_nobody_else_is_let_in(network: Network, who: str, tmp_path: Path) -> None:
    route = link.Link(connect=(network.endpoint,))
    if who != "nobody":
        own = read_identity(network.folder / "agent.iwid")
        text = f'{{"Identity":"iw.v1","Name":"{own.name if "wrong" in who else "mallory"}","Password":"12345678"}}'
        write_secret(tmp_path / "other.iwid", text.encode())
        route = link.Link(connect=(network.endpoint,), identity=tmp_path / "other.iwid")
    words = "expects --identity FILE" if who == "nobody" else "was revoked, is of another lab, or is newer"
    with pytest.raises(ConnectionError, match=words):
        link.open_session(route, threading.Event(), timeout=0.0)


def test_password_is_in_no_command_line_and_no_log(network: Network) -> None:
    password = read_identity(network.folder / "simulator.iwid").password
    for line in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            assert password.encode() not in line.read_bytes()
        except (FileNotFoundError, ProcessLookupError):
            continue
    for log in network.folder.rglob("*.log"):
        assert password not in log.read_text(errors="replace")


def test_who_has_the_right_identity_drives_and_others_are_told(network: Network) -> None:
    stage, folder = network.stage, network.folder

    def start(child: str, module: str, identity: str, *words: str) -> str:
        # The endpoint is in the file.
        return stage.start(child, module, *words, "--world", "other2", "--identity", str(folder / f"{identity}.iwid"))

    (folder / "ask").unlink(missing_ok=True)
    os.mkfifo(folder / "ask")
    port = folder / "tty"
    stage.start(
        "firmware", "intellwheels_agents.bridge.firmware_stand_in", "--link", str(port), "--ask", str(folder / "ask")
    )
    stage.line("firmware", "ready")
    stage.line(start("server", "intellwheels_server", "simulator2", "--map", "room", "--pace", "realtime"), "ready")
    assert "open:" not in stage.log("server")
    spin = ("--option", "left=0.2", "--option", "right=-0.2")
    stage.line(start("agent", "intellwheels_agents", "student2", "drive", "--name", "a2-x", *spin), "joined")
    bridge = "intellwheels_agents.bridge"
    stage.line(start("bridge", bridge, "bridge2", "serial", "--port", str(port), "--name", "real2"), "joined")
    mind = start("mind", "intellwheels_agents", "student2", "drive", "--name", "real2", "--role", "mind", *spin)
    stage.line(mind, "joined")
    stage.line("firmware", "moving")
    # Another's name, with a valid identity: the words of a denial.
    other = start("other", "intellwheels_agents", "student2", "drive", "--name", "b1-x", "--retry-for", "0.5")
    assert stage.exit(other) == 1
    assert "student2 may not be the body and mind of 'b1-x' in world other2, only a2-*" in stage.log(other)
    script = folder / "script.txt"
    script.write_text("1 0.1 0\n")
    denials = (
        ("joystick", "intellwheels_agents.joystick", ("b1-x", "--source", "script", "--script", str(script)),
         "student2 may not write user/b1-x in world other2"),
        ("second", "intellwheels_server", ("--map", "room"), "student2 may not be the simulator of world other2"),
    )  # fmt: skip
    for child, module, words, text in denials:
        denied = start(child, module, "student2", *words)
        assert stage.exit(denied) == 1
        assert text in stage.log(denied)
    link_words = ("--world", "other2", "--identity", str(folder / "student2.iwid"))
    done = run("intellwheels_schemas.present", "--agent", "b1-x", *link_words)
    assert (done.returncode, done.stderr) == (
        1, "present: student2 may not see in/b1-x/alive/*/* in world other2\n"
    )  # fmt: skip
    page = viewer_peer.Network(
        link.Link("other2", connect=(network.endpoint,), identity=folder / "student2.iwid"), threading.Event()
    )
    page.start()
    try:
        stage.wait(lambda: {"a2-x", "real2"} == set(page.update().bodies) or None, "both chairs on the page")
        assert page.update().phase == "live"
        rights = stage.wait(lambda: page.update().rights, "what the page may do")
        assert rights.name == "student2"
        with pytest.raises(Refusal, match="View only: student2 may not ask for ctl/pause in world other2"):
            page.ask("pause", Pause())
    finally:
        page.close()
    for child in ("mind", "bridge", "agent", "server"):
        stage.signal(child, signal.SIGTERM)
        assert stage.exit(child) == 0
