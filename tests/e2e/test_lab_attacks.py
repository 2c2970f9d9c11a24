"""Every attack on a lab, as every kind of identity that gets in, over every way in; and its rightful twin.

One router and one simulator serve all cases, with a chair of student1 and a real chair on a firmware stand-in. Who may
do what on which key is in `test_lab_access`. Here are strangers, and the processes that must not notice them.
"""

from __future__ import annotations

import datetime
import itertools
import json
import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import msgspec
import pytest
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.codec import LIMITS
from intellwheels_schemas.files import write_file
from intellwheels_schemas.identity_file import identity_text, read_identity, write_secret
from intellwheels_schemas.keys import AGENT_VERBS, VERBS
from intellwheels_schemas.messages import Actions, Identity, Lab, May
from intellwheels_server.service import lab_keys
from intellwheels_server.service.lab_certificates import authority_of, issue_for
from intellwheels_server.service.lab_files import LabFiles
from tests.e2e.stage import DEADLINE, JSON, Stage, free_port

pytestmark = pytest.mark.process

OWN, REAL, LAST = "st1-a", "real1", 2**53 - 1
CREW, MEMBER, OTHER_CREW = "st1-k", "st1-k1", "st2-x"
"""A crew of student1 with two agents, and the name of one that a stranger may have."""
MARK = "dead000000000000"
"""In every payload of a stranger, as its Run or Session."""
WAYS = ("password", "certificate", "router")
"""A password by TCP, a password and a certificate by TLS, and a process that says it is a router itself."""
STRANGERS = ("agent", "viewer", "operator")
OUTSIDE = ("expired", "revoked", "foreign", "none")

_ROLES: dict[str, tuple[May, ...]] = {
    "simulator": (May(role="simulator"), May(role="simulator", world="other")),
    "student1": (May(role="agent", agents=("st1-*",)), May(role="viewer", agents=("st1-*",))),
    "mind1": (May(role="mind", agents=(REAL,)),),
    "teacher": (May(role="operator", agents=("*",)), May(role="recorder")),
    "agent": (May(role="agent", agents=("st2-*",)),),
    "viewer": (May(role="viewer", agents=("st2-*",)),),
    "operator": (May(role="operator", world="other", agents=("*",)),),
}
LAB = Lab(
    format="iw.v1",
    name="attacked",
    identity=(
        *(Identity(name=name, may=may) for name, may in _ROLES.items() if name not in STRANGERS),
        # One for each way in, so that the router's report tells them apart.
        *(Identity(name=f"{name}-{way}", may=_ROLES[name]) for name in STRANGERS for way in WAYS),
        Identity(name="bridge1", certificate=True, may=(May(role="bridge", agents=(REAL,)),)),
        Identity(name="expired", until="2090-01-01", may=_ROLES["teacher"]),
        Identity(name="revoked", may=_ROLES["teacher"]),
        Identity(name="foreign", may=_ROLES["teacher"]),
    ),
)


class Attack(NamedTuple):
    """What a stranger does, and who may do the same; nobody but the simulator, if that is empty."""

    does: str
    key: str
    fields: Mapping[str, Any] = MappingProxyType({})
    twin: str = ""


_MOTORS = {"Session": MARK, "LeftMotor": 1.0, "RightMotor": -1.0}
_POSE = {"Session": MARK, "X": 3.0, "Y": 3.0, "Heading": 0.0}
_RUN = {"Run": MARK, "Tick": LAST, "Time": 1.0}
_ACTS = {"Crew": CREW, "Actions": [{"Agent": MEMBER} | _MOTORS]}
ATTACKS: dict[str, Attack] = {
    "drive another's chair": Attack("puts", f"in/{OWN}/actions", _MOTORS, "student1"),
    "drive a real chair": Attack("puts", f"in/{REAL}/actions", _MOTORS, "mind1"),
    "speak in its name": Attack("puts", f"in/{OWN}/say", {"Session": MARK, "Text": "hello"}, "student1"),
    "join in its name": Attack("asks", f"join/{OWN}", {"Name": OWN, "Instance": MARK}, "student1"),
    "steal the key of a bridge": Attack("asks", f"join/{REAL}", {"Name": REAL, "Instance": MARK}, "bridge1"),
    "read its session": Attack("reads", f"in/{OWN}/actions", {}, "teacher"),
    "read the codes of its poses": Attack("reads", f"in/{REAL}/pose", {}, "teacher"),
    "steer it": Attack("puts", f"user/{OWN}", {"Lease": MARK, "Forward": 1.0, "Turn": 0.0}, "student1"),
    "make it leave": Attack("asks", f"leave/{OWN}", {}, "student1"),
    "keep its token after its death": Attack("appears", f"in/{OWN}/alive/both/{MARK}", {}, "student1"),
    "appear as a bridge": Attack("appears", f"in/{REAL}/alive/body/{MARK}", {}, "bridge1"),
    "act for a crew": Attack("puts", f"crew/{CREW}/actions", _ACTS, "student1"),
    "act for another's agent with a foreign crew": Attack("puts", f"crew/{OWN}/actions", _ACTS, "student1"),
    "join with a crew": Attack("asks", f"crew/{CREW}/join", {"Crew": CREW, "Instance": MARK}, "student1"),
    "make a crew leave": Attack("asks", f"crew/{CREW}/leave", {"Crew": CREW}, "student1"),
    "lend its chair to a crew": Attack("appears", f"in/{OWN}/alive/both/{MARK}/{OTHER_CREW}", {}, "student1"),
    "keep the token of a crew": Attack("appears", f"in/{MEMBER}/alive/both/{MARK}/{CREW}", {}, "student1"),
    "read the sessions of a crew": Attack("reads", f"crew/{CREW}/actions", {}, "teacher"),
    "make a crew deaf": Attack("puts", f"crew/{CREW}/measures", {"Crew": CREW, "Measures": [_RUN | {"Agent": MEMBER}]}),
    "say that a crew was deleted": Attack(
        "puts", f"crew/{CREW}/error", _RUN | {"Code": "deleted", "Text": "deleted", "Agent": MEMBER}
    ),
    "answer a crew": Attack("answers", "crew/*/join"),
    "report its pose": Attack("puts", f"in/{REAL}/pose", _POSE, "bridge1"),
    "give its motors power": Attack("puts", f"out/{REAL}/power", _RUN | {"LeftMotor": 1.0, "RightMotor": -1.0}),
    "read its powers": Attack("reads", f"out/{REAL}/power", {}, "bridge1"),
    "make it deaf": Attack("puts", f"out/{REAL}/measures", _RUN),
    "silence a mind with another run": Attack("puts", f"out/{OWN}/measures", _RUN),
    "say that it was deleted": Attack("puts", f"out/{OWN}/error", _RUN | {"Code": "deleted", "Text": "deleted"}),
    "show a false state": Attack("puts", "state/0", _RUN),
    "show a false clock": Attack("puts", "clock", _RUN),
    "show false events": Attack("puts", "event", _RUN),
    "show a false map": Attack("puts", "map", {"Name": "x", "Revision": LAST, "Hash": MARK}),
    "show a false body": Attack("puts", f"body/{OWN}", _RUN),
    "answer a join": Attack("answers", "join/*"),
    "answer for the clock": Attack("answers", "clock"),
    "answer everything": Attack("answers", "**"),
    "take the world's name": Attack("appears", "alive"),
    "claim the world from the past": Attack("appears", f"alive/1000000000000/{MARK}"),
    "read everything": Attack("reads", "in/**"),
    **{
        f"ask for {verb}": Attack("asks", f"ctl/{verb}/{OWN}" if verb in AGENT_VERBS else f"ctl/{verb}", {}, "teacher")
        for verb in VERBS
    },
}  # fmt: skip
_STOPS = {"quit", "reset", "load", "delete"}
"""Verbs whose twin would end what the other cases need: the teacher asks wrongly, and the simulator's refusal proves
that the question arrived."""


class Room:
    """A lab with everything running."""

    def __init__(self, stack: ExitStack, stage: Stage, folder: Path) -> None:
        self.stage, self.folder, self._stack = stage, folder, stack
        ends = {"tcp": f"tcp/127.0.0.1:{free_port()}", "tls": f"tls/127.0.0.1:{free_port()}"}
        self.ends = {"password": ends["tcp"], "router": ends["tcp"], "certificate": ends["tls"]}
        self._write_identities()
        words = itertools.chain.from_iterable(("--listen", end) for end in ends.values())
        lab = str(folder / "lab.xml")
        stage.line(stage.start("router", "intellwheels_server.service.router", "--lab", lab, *words), "ready")
        os.mkfifo(folder / "ask")
        port = str(folder / "tty")
        stand_in = "intellwheels_agents.bridge.firmware_stand_in"
        stage.start("firmware", stand_in, "--link", port, "--ask", str(folder / "ask"))
        self.start("server", "intellwheels_server", "simulator", "--map", "room", "--pace", "realtime")
        stage.line("server", "ready", 120.0)
        spin = ("--option", "left=0.2", "--option", "right=-0.2")
        self.start("chair", "intellwheels_agents", "student1", "drive", "--name", OWN, *spin)
        self.start("bridge", "intellwheels_agents.bridge", "bridge1", "serial", "--port", port, "--name", REAL)
        self.start("crew", "intellwheels_agents", "student1", "drive", "--count", "2", "--name", CREW, *spin)
        for child in ("chair", "bridge", "crew"):
            stage.line(child, "joined")
        self.teacher = self.session("teacher", "certificate")
        self.heard: deque[tuple[str, bytes]] = deque(maxlen=20_000)
        # The recorder may read these, and no wider keys.
        for key in (
            "in/*/actions", "in/*/say", "in/*/pose", "user/*", "out/*/measures", "out/*/power", "out/*/error",
            "state/*", "clock", "event", "map", "body/*", "crew/*/actions", "crew/*/measures", "crew/*/error",
        ):  # fmt: skip
            # Called at once, so that whatever came before the answer to a query has been heard when it is there.
            hear: Any = zenoh.handlers.Callback(self._hear, indirect=False)
            self.teacher.declare_subscriber(f"iw/v1/main/{key}", hear)
        self.student = self.session("student1", "certificate")
        self.other = self.session("simulator", "password")
        self.other.declare_queryable("iw/v1/other/map", _answer)
        self.sessions = {(who, way): self.session(f"{who}-{way}", way) for who in STRANGERS for way in WAYS}
        for (who, _), session in self.sessions.items():
            self.settle(session, "other" if who == "operator" else "main")

    def _write_identities(self) -> None:
        """Write the files of all identities; those that must not get in are void before the router starts."""
        folder, lab = self.folder, self.folder / "lab.xml"
        lab.write_text(write_file(LAB))
        assert lab_keys.main(["keys", "--lab", str(lab)]) == 0
        for identity in LAB.identity:
            words = ["invite", identity.name, "--lab", str(lab), "--connect", self.ends["certificate"]]
            assert lab_keys.main([*words, "--out", str(folder / f"{identity.name}.iwid")]) == 0
        assert lab_keys.main(["revoke", "revoked", "--lab", str(lab)]) == 0
        late = msgspec.structs.replace(LAB.identity[-3], until="2020-01-01")
        lab.write_text(
            write_file(msgspec.structs.replace(LAB, identity=(*LAB.identity[:-3], late, *LAB.identity[-2:])))
        )
        assert lab_keys.main(["keys", "--lab", str(lab)]) == 0
        # The right password with a certificate of another authority, and one that has ended.
        today = datetime.datetime.now(datetime.UTC).date()
        yesterday = today - datetime.timedelta(days=1)
        there = folder / "there"
        there.mkdir()
        for name, files, until in (
            ("foreign", LabFiles(there / "lab.xml"), today),
            ("ended", LabFiles(lab), yesterday),
        ):
            issued = issue_for(authority_of(files, "x", today), "foreign", until, today)
            own = msgspec.structs.replace(
                read_identity(folder / "foreign.iwid"), certificate=issued.certificate, private_key=issued.key
            )
            write_secret(folder / f"{name}-certificate.iwid", identity_text(own))

    def start(self, child: str, module: str, identity: str, *words: str) -> None:
        """Start a process with an identity, which has the endpoint."""
        self.stage.start(child, module, *words, "--identity", str(self.folder / f"{identity}.iwid"))

    def route(self, name: str, way: str) -> link.Link:
        return link.Link(connect=(self.ends[way],), identity=self.folder / f"{name}.iwid")

    def session(self, name: str, way: str) -> zenoh.Session:
        config = link.config_of(self.route(name, way))
        if way == "router":
            config.insert_json5("mode", '"router"')
            config.insert_json5("listen/endpoints", "[]")
        return self._stack.enter_context(zenoh.open(config))

    def settle(self, session: zenoh.Session, world: str = "main") -> None:
        """Return when everybody has what a session sent before."""
        for asks, key in ((session, f"iw/v1/{world}/map"), (self.teacher, "iw/v1/main/map")):
            assert link.query(asks, key, timeout=DEADLINE)[0].ok

    def ticks(self, count: int) -> None:
        """Wait until the simulator has shown so many ticks."""
        first = len(self.heard)

        def found() -> bool | None:
            return sum(key.endswith("/clock") for key, _ in list(self.heard)[first:]) >= count or None

        self.stage.wait(found, f"{count} ticks", unless="server")

    def is_reported(self, words: str) -> None:
        """Wait until the router has said that something was denied."""
        self.stage.wait(lambda: words in self.stage.log("router") or None, f"{words!r} of the router", unless="server")

    def _hear(self, sample: zenoh.Sample) -> None:
        self.heard.append((str(sample.key_expr), bytes(sample.payload)))


def _answer(query: zenoh.Query) -> None:
    with query:
        query.reply(str(query.key_expr), MARK.encode())


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Room]:
    folder = tmp_path_factory.mktemp("attacked")
    with Stage(folder, "main") as stage, ExitStack() as stack:
        found = Room(stack, stage, folder)
        runs = {json.loads(data)["Run"] for key, data in _later(found, "/clock")}
        yield found
        # Nobody noticed anything: the same run, the same processes, motors that never started.
        assert {json.loads(data)["Run"] for key, data in _later(found, "/clock")} == runs
        assert {"router", "server", "chair", "bridge", "firmware", "crew"} <= {*stage.running}
        assert "moving" not in stage.log("firmware")
        for child in ("chair", "bridge", "crew"):
            assert "dropped message" not in stage.log(child)


def _later(room: Room, ending: str) -> list[tuple[str, bytes]]:
    first = len(room.heard)
    room.stage.wait(lambda: any(k.endswith(ending) for k, _ in list(room.heard)[first:]) or None, ending)
    return [(key, data) for key, data in list(room.heard)[first:] if key.endswith(ending)]


def _puts(room: Room, session: zenoh.Session, attack: Attack, settle: Callable[[], None]) -> bool:
    room.heard.clear()
    session.put(f"iw/v1/main/{attack.key}", json.dumps(dict(attack.fields)).encode(), encoding=JSON)
    settle()
    return any(key.endswith(attack.key) and MARK.encode() in data for key, data in list(room.heard))


def _asks(room: Room, session: zenoh.Session, attack: Attack, settle: Callable[[], None]) -> bool:
    verb = attack.key.split("/")[1] if attack.key.startswith("ctl/") else ""
    data = b"?" if verb in _STOPS else json.dumps(dict(attack.fields)).encode()
    words = _refusal(session, f"iw/v1/main/{attack.key}", data)
    assert words == "" or "or not allowed" in words
    return not words


def _refusal(session: zenoh.Session, key: str, data: bytes) -> str:
    try:
        link.query(session, key, data, timeout=DEADLINE)
    except ConnectionError as error:
        return str(error)
    return ""


def _reads(room: Room, session: zenoh.Session, attack: Attack, settle: Callable[[], None]) -> bool:
    heard: list[str] = []

    def store(sample: zenoh.Sample) -> None:
        heard.append(str(sample.key_expr))

    hear = zenoh.handlers.Callback(store, indirect=False)
    subscriber: Any = session.declare_subscriber(f"iw/v1/main/{attack.key}", hear)
    settle()
    room.ticks(2)
    settle()
    subscriber.undeclare()
    return bool(heard)


def _appears(room: Room, session: zenoh.Session, attack: Attack, settle: Callable[[], None]) -> bool:
    key = f"iw/v1/main/{attack.key}"
    before = link.tokens(room.other, key)
    token: Any = session.liveliness().declare_token(key)
    settle()
    after = link.tokens(room.other, key)
    token.undeclare()
    settle()
    # The simulator has its own token `alive`; a second one would stay when the first goes.
    return before != after


def _answers(room: Room, session: zenoh.Session, attack: Attack, settle: Callable[[], None]) -> bool:
    queryable: Any = session.declare_queryable(f"iw/v1/main/{attack.key}", _answer)
    settle()
    key = attack.key.replace("*", "st1-z") if "join" in attack.key else "clock"
    answers = link.query(room.student, f"iw/v1/main/{key}", timeout=DEADLINE)
    queryable.undeclare()
    return any(answer.data == MARK.encode() for answer in answers)


_DOES = {"puts": _puts, "asks": _asks, "reads": _reads, "appears": _appears, "answers": _answers}
_VERBS = {"puts": "write", "asks": "ask for", "reads": "read", "appears": "appear at", "answers": "answer"}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("who", STRANGERS)
@pytest.mark.parametrize("attack", ATTACKS)
def test_stranger_achieves_nothing_and_is_reported(room: Room, attack: str, who: str, way: str) -> None:
    session, case = room.sessions[who, way], ATTACKS[attack]
    world = "other" if who == "operator" else "main"
    assert not _DOES[case.does](room, session, case, lambda: room.settle(session, world))
    if (who, way) == ("operator", "router") and case.does in ("puts", "asks"):
        return  # a router that is not told who listens in a world sends nothing to it
    key = case.key.replace(f"/{MARK}", "/*").replace(f"/*/{OTHER_CREW}", "/*").replace(f"/*/{CREW}", "/*")
    room.is_reported(
        f"{who}-{way} may not {_VERBS[case.does]} {key.replace('alive/1000000000000/*', 'alive/*')} in world"
    )


@pytest.mark.parametrize("attack", [name for name, attack in ATTACKS.items() if attack.twin])
def test_who_may_does_the_same(room: Room, attack: str) -> None:
    case = ATTACKS[attack]
    session = room.session(case.twin, "certificate")
    room.settle(session)
    assert _DOES[case.does](room, session, case, lambda: room.settle(session))
    if attack in ("ask for pause", "ask for step", "ask for seek", "ask for restore"):
        assert link.query(room.teacher, "iw/v1/main/ctl/resume", b"{}")[0].ok


def test_while_strangers_forge_each_tick_is_answered_before_the_next(room: Room) -> None:
    def ask(verb: str) -> None:
        assert link.query(room.teacher, f"iw/v1/main/ctl/{verb}", b"{}", timeout=DEADLINE)[0].ok

    # No tick passes but those that are asked for.
    ask("pause")
    for _ in range(3):
        room.heard.clear()
        for (who, _), session in room.sessions.items():
            for attack in ("make it deaf", "silence a mind with another run", "give its motors power"):
                session.put(f"iw/v1/main/{ATTACKS[attack].key}", json.dumps(dict(ATTACKS[attack].fields)).encode())
            room.settle(session, "other" if who == "operator" else "main")
        ask("step")
        (clock,) = link.query(room.teacher, "iw/v1/main/clock", timeout=DEADLINE)
        tick = json.loads(clock.data)["Tick"]

        def answered(tick: int = tick) -> bool | None:
            found = {key.removeprefix("iw/v1/main/") for key, data in list(room.heard) if _tick_of(data) == tick}
            return found >= {f"in/{REAL}/pose", f"in/{OWN}/actions"} or None

        room.stage.wait(answered, f"answers to tick {tick}")
        (clock,) = link.query(room.teacher, "iw/v1/main/clock", timeout=DEADLINE)
        assert json.loads(clock.data)["Tick"] == tick
    ask("resume")


def _tick_of(data: bytes) -> Any:
    return json.loads(data).get("Tick")


@pytest.mark.parametrize("way", ["password", "certificate"])
def test_crew_of_a_stranger_gets_no_agent_of_others(room: Room, way: str) -> None:
    session, own = room.sessions["agent", way], f"{OTHER_CREW}-{way}"
    agents = [MEMBER, OWN, "st1-z", own]
    tokens: list[Any] = [
        session.liveliness().declare_token(f"iw/v1/main/in/{agent}/alive/both/{MARK}/{OTHER_CREW}") for agent in agents
    ]
    place = {"X": 3.0 if way == "password" else 4.0, "Y": 6.5, "Heading": 0.0}
    size = {"Length": 0.4, "Width": 0.4, "TopSpeed": 1.0}
    robots = [{"Name": agent, "Position": place, **size} for agent in agents]
    join = {"Crew": OTHER_CREW, "Instance": MARK, "Robot": robots}
    (answer,) = link.query(session, f"iw/v1/main/crew/{OTHER_CREW}/join", json.dumps(join).encode(), timeout=DEADLINE)
    reply = json.loads(answer.data)
    assert {one["Agent"]: one["Code"] for one in reply["Refused"]} == dict.fromkeys(agents[:3], "no-token")
    (joined,) = reply["Joined"]
    assert joined["Agent"] == own
    # Its session is of no use for other agents, and theirs are of none in its crew.
    room.heard.clear()
    acts = {
        "Crew": OTHER_CREW,
        "Actions": [{"Agent": a, "Session": joined["Session"], "LeftMotor": 0.0} for a in agents],
    }
    session.put(f"iw/v1/main/crew/{OTHER_CREW}/actions", json.dumps(acts).encode(), encoding=JSON)
    room.settle(session)
    room.ticks(2)

    def errors() -> set[tuple[str, str, str]]:
        """Return the receiver, agent and code of each error. On a busy machine the room's own agents are late."""
        heard = [(key.split("/")[-2], json.loads(data)) for key, data in list(room.heard) if key.endswith("/error")]
        return {(to, error.get("Agent"), error["Code"]) for to, error in heard if error["Code"] != "late"}

    expected = {(OTHER_CREW, agent, "not-joined") for agent in agents[:3]}
    room.stage.wait(lambda: errors() >= expected or None, "errors of the agents that have not joined")
    assert errors() == expected
    leave = {"Crew": OTHER_CREW, "Leave": [{"Agent": own, "Session": joined["Session"]}]}
    assert link.query(session, f"iw/v1/main/crew/{OTHER_CREW}/leave", json.dumps(leave).encode())[0].ok
    for token in tokens:
        token.undeclare()
    room.settle(session)


@pytest.mark.parametrize("way", ["password", "certificate"])
@pytest.mark.parametrize("who", OUTSIDE)
def test_who_is_no_identity_any_more_does_not_get_in_and_is_told(room: Room, who: str, way: str) -> None:
    route = room.route(who, way)
    if who == "foreign" and way == "certificate":
        route = room.route("foreign-certificate", way)
    if who == "foreign" and way == "password":
        own = read_identity(room.folder / "foreign.iwid")
        write_secret(room.folder / "wrong.iwid", identity_text(msgspec.structs.replace(own, password="x" * 32)))
        route = room.route("wrong", way)
    if who == "none":
        route = link.Link(connect=route.connect)
    words = "expects --identity FILE" if who == "none" else "refuses .* ask for another file, made with iw-lab invite"
    with pytest.raises(ConnectionError, match=words):
        link.open_session(route, threading.Event(), timeout=0.0)
    if who == "none":
        # Whoever knows no lab does not know the authority of the router's certificate either.
        shown = "showed no identity" if way == "password" else "is of no lab or another one"
    else:
        stranger = who == "foreign" and way == "certificate"
        shown = f"showed {'a certificate of another lab' if stranger else 'an unknown name or a wrong password'}"
    room.is_reported(f"somebody {shown}")


def test_certificate_ends_for_the_router_too(room: Room) -> None:
    with pytest.raises(ConnectionError, match="refuses foreign"):
        link.open_session(room.route("ended-certificate", "certificate"), threading.Event(), timeout=0.0)
    room.is_reported("somebody showed a certificate that has expired")


def test_password_alone_is_not_enough_where_a_certificate_is_asked_for(room: Room) -> None:
    session = room.session("bridge1", "password")
    with pytest.raises(ConnectionError, match="or not allowed"):
        link.query(session, "iw/v1/main/map", timeout=DEADLINE)


def test_long_messages_end_at_the_router(room: Room) -> None:
    agent, key = room.sessions["agent", "password"], "iw/v1/main/in/st2-a/actions"
    limit = LIMITS[Actions]
    room.heard.clear()
    for size in (limit, limit + 1):
        agent.put(key, b"x" * size)
        room.settle(agent)
    assert [len(data) for heard, data in list(room.heard) if heard == key] == [limit]
    room.is_reported("agent-password may not write in/st2-a/actions in world main at such length")


def test_flood_of_messages_leaves_others_their_ticks_and_commands(room: Room) -> None:
    agent, kinds = room.sessions["agent", "password"], ("actions", "say")
    publishers: list[Any] = [agent.declare_publisher(f"iw/v1/main/in/st2-a/{kind}") for kind in kinds]
    for _ in range(10_000):
        for publisher in publishers:
            publisher.put(b"{}")
    room.settle(agent)
    room.heard.clear()  # it keeps the newest only, and `_later` looks at what comes after the others
    # Another student's chair goes on, and the simulator dropped most of the flood unread.
    assert _later(room, f"in/{OWN}/actions")
    room.ticks(5)
    assert link.query(room.teacher, "iw/v1/main/ctl/resume", b"{}", timeout=DEADLINE)[0].ok
    room.stage.wait(lambda: "dropped arrivals=" in room.stage.log("server") or None, "report of what was dropped")
    for publisher in publishers:
        publisher.undeclare()


def test_flood_of_queries_and_tokens_leaves_others_their_ticks_and_answers(room: Room) -> None:
    viewer, agent = room.sessions["viewer", "password"], room.sessions["agent", "password"]
    tokens: list[Any] = []
    ended = itertools.count(1)
    over, rounds, keys = threading.Event(), 200, ("map", "clock", "event", "body/*", "state/*")

    def on_end() -> None:
        if next(ended) == rounds * len(keys):
            over.set()

    for number in range(rounds):
        for key in keys:
            done: Any = zenoh.handlers.Callback(lambda _reply: None, on_end)
            viewer.get(f"iw/v1/main/{key}", done, timeout=DEADLINE)
        tokens += [
            agent.liveliness().declare_token(f"iw/v1/main/in/st2-a/alive/both/{number:08x}{more:08x}")
            for more in range(5)
        ]
    # Meanwhile others are answered, and their chairs go on.
    assert link.query(room.teacher, "iw/v1/main/ctl/resume", b"{}", timeout=DEADLINE)[0].ok
    room.ticks(5)
    assert _later(room, f"in/{OWN}/actions")
    words = ("drive", "--name", "st1-late")
    room.start("late", "intellwheels_agents", "student1", *words)
    room.stage.line("late", "joined")
    assert over.wait(DEADLINE), "each query has an end"
    for token in tokens:
        token.undeclare()
    room.stage.end(["late"])


def test_no_secret_is_in_a_log_a_command_line_or_an_environment(room: Room) -> None:
    secrets = []
    for file in room.folder.glob("*.iwid"):
        own = read_identity(file)
        secrets += [own.password.encode(), own.private_key.encode()[40:80]]
    secrets += [(room.folder / name).read_bytes()[40:80] for name in ("lab.ca.key", "lab.router.key")]
    texts = [log.read_bytes() for log in room.folder.rglob("*.log")]
    for what in ("cmdline", "environ"):
        for path in Path("/proc").glob(f"[0-9]*/{what}"):
            try:
                texts.append(path.read_bytes())
            except OSError:
                continue
    assert len(texts) > 10
    assert not any(secret in text for secret in secrets for text in texts)
