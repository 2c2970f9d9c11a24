"""Makes and parses every key. No other module does.

A key contains the name of its writer, so the key of a sample gives the sender. Parsers are strict: for a key with a
wildcard, an invalid name or too many chunks they return None.
"""

from __future__ import annotations

from typing import Final, Literal, NamedTuple, get_args

from intellwheels_schemas import defaults
from intellwheels_schemas.messages import ControlVerb, Record, Role
from intellwheels_schemas.names import check_name, is_hex, is_name

ROOT: Final = "iw/v1"
EVERY_ALIVE: Final = f"{ROOT}/*/alive"
"""Key expression for the liveliness tokens of all simulators, used to find worlds."""

InKind = Literal["actions", "say", "pose"]
OutKind = Literal["measures", "power", "error"]
Verb = ControlVerb

IN_KINDS: Final[dict[str, InKind]] = {kind: kind for kind in get_args(InKind)}
OUT_KINDS: Final[dict[str, OutKind]] = {kind: kind for kind in get_args(OutKind)}
VERBS: Final[dict[str, Verb]] = {verb: verb for verb in get_args(Verb)}
AGENT_VERBS: Final[frozenset[Verb]] = frozenset({"delete", "teleport", "take"})
"""Verbs about one agent. Their keys name it, so that a router can grant the right to one agent."""
ROLES: Final[dict[str, Role]] = {role: role for role in get_args(Role)}


class In(NamedTuple):
    """Writer and kind of a key `in/<agent>/<kind>`."""

    agent: str
    kind: InKind


class Out(NamedTuple):
    """Addressee and kind of a key `out/<agent>/<kind>`."""

    agent: str
    kind: OutKind


class Token(NamedTuple):
    """Owner of the liveliness token `in/<agent>/alive/<role>/<instance>`."""

    agent: str
    role: Role
    instance: str


class Control(NamedTuple):
    """Verb of a key `ctl/<verb>`, and the agent of a key `ctl/<verb>/<agent>`, empty if the key has none."""

    verb: Verb
    agent: str = ""


class Claim(NamedTuple):
    """Holder of the liveliness token `alive/<since>/<instance>`: a simulator that claims a world.

    Attributes:
        since: When the claim began, in nanoseconds of Unix time; 16 hex digits in the key. The smaller of two wins.
        instance: The first 16 of the 32 hex digits of its Zenoh id.
    """

    since: int
    instance: str


class Keys:
    """The keys of one world.

    Attributes:
        world: Name of the world.
        prefix: Start of all keys of the world, with the last slash.
        map, event, clock, alive: The keys without a name in them.
        every_join, every_leave, every_in, every_user: Key expressions for the simulator.
        every_ctl: Key expressions for all control verbs.
        every_claim: Key expression for the liveliness tokens of the simulators that claim the world.
        every_put: Key expressions for everything that agents and users put, also on unknown keys.
        every_token: Key expression for the liveliness tokens of all agents.
        every_body, every_state: Key expressions for recorders and viewers.

    Raises:
        WireError: `value`, if the name of the world is invalid.
    """

    def __init__(self, world: str = defaults.WORLD) -> None:
        self.world = check_name(world, "world")
        self.prefix = p = f"{ROOT}/{world}/"
        self.map = f"{p}map"
        self.event = f"{p}event"
        self.clock = f"{p}clock"
        self.alive = f"{p}alive"
        self.every_claim = f"{p}alive/*/*"
        self.every_join = f"{p}join/*"
        self.every_leave = f"{p}leave/*"
        self.every_in = f"{p}in/*/*"
        self.every_user = f"{p}user/*"
        self.every_put = (f"{p}in/**", f"{p}user/**")
        self.every_ctl = (f"{p}ctl/*", f"{p}ctl/*/*")
        self.every_token = f"{p}in/*/alive/*/*"
        self.every_body = f"{p}body/*"
        self.every_state = f"{p}state/*"

    # ------------------------------------------------------------ make

    def join(self, agent: str) -> str:
        """Return the key that an agent queries to join."""
        return f"{self.prefix}join/{check_name(agent, 'agent')}"

    def leave(self, agent: str) -> str:
        """Return the key that an agent queries to leave."""
        return f"{self.prefix}leave/{check_name(agent, 'agent')}"

    def in_(self, agent: str, kind: InKind) -> str:
        """Return a key that an agent writes."""
        return f"{self.prefix}in/{check_name(agent, 'agent')}/{kind}"

    def actions(self, agent: str) -> str:
        """Return the key of an agent's `Actions`."""
        return self.in_(agent, "actions")

    def say(self, agent: str) -> str:
        """Return the key of an agent's `Say`."""
        return self.in_(agent, "say")

    def pose(self, agent: str) -> str:
        """Return the key of the `Pose` of a real robot."""
        return self.in_(agent, "pose")

    def token(self, agent: str, role: Role, instance: str) -> str:
        """Return the key of an agent's liveliness token; `instance` is 16 hex digits, new in each process."""
        if not is_hex(instance) or role not in ROLES:
            raise ValueError(f"expected a role and 16 hex digits, got {role!r}, {instance!r}")
        return f"{self.prefix}in/{check_name(agent, 'agent')}/alive/{role}/{instance}"

    def claim(self, claim: Claim) -> str:
        """Return the key of a simulator's claim on the world."""
        if not is_hex(claim.instance) or not 0 <= claim.since < 1 << 64:
            raise ValueError(f"expected nanoseconds and 16 hex digits, got {claim}")
        return f"{self.prefix}alive/{claim.since:016x}/{claim.instance}"

    def tokens(self, agent: str) -> str:
        """Return the key expression that matches all liveliness tokens of one agent."""
        return f"{self.prefix}in/{check_name(agent, 'agent')}/alive/*/*"

    def user(self, agent: str) -> str:
        """Return the key of `UserInput` for an agent."""
        return f"{self.prefix}user/{check_name(agent, 'agent')}"

    def read_of(self, agent: str) -> tuple[str, ...]:
        """Return the keys of an agent that the simulator reads: those that it writes, and that of its user."""
        return (*(self.in_(agent, kind) for kind in IN_KINDS.values()), self.user(agent))

    def out(self, agent: str, kind: OutKind) -> str:
        """Return a key that the simulator writes for an agent."""
        return f"{self.prefix}out/{check_name(agent, 'agent')}/{kind}"

    def outs(self, agent: str) -> str:
        """Return the key expression that matches everything that the simulator writes for an agent."""
        return f"{self.prefix}out/{check_name(agent, 'agent')}/*"

    def measures(self, agent: str) -> str:
        """Return the key of an agent's `Measures`."""
        return self.out(agent, "measures")

    def power(self, agent: str) -> str:
        """Return the key of the `Power` for a real robot."""
        return self.out(agent, "power")

    def error(self, agent: str) -> str:
        """Return the key of an agent's `Error` messages."""
        return self.out(agent, "error")

    def body(self, agent: str) -> str:
        """Return the key of a `Body`."""
        return f"{self.prefix}body/{check_name(agent, 'agent')}"

    def state(self, part: int) -> str:
        """Return the key of a part of the `WorldState`, counted from 0."""
        return f"{self.prefix}state/{part}"

    def ctl(self, verb: Verb, agent: str | None = None) -> str:
        """Return the key of a control verb; `agent` is given for the verbs in `AGENT_VERBS`, and for no others."""
        if (agent is not None) != (verb in AGENT_VERBS):
            raise ValueError(f"expected {'an agent' if agent is None else 'no agent'} for ctl/{verb}, got {agent!r}")
        return f"{self.prefix}ctl/{verb}" + (f"/{check_name(agent, 'agent')}" if agent is not None else "")

    def ctl_of(self, verb: Verb, message: Record) -> str:
        """Return the key on which a control message is sent. The message names its agent, if it has one."""
        return self.ctl(verb, getattr(message, "agent", None) if verb in AGENT_VERBS else None)

    def crew_actions(self, crew: str) -> str:
        """Return the key of a crew's `CrewActions`."""
        return f"{self.prefix}crew/{check_name(crew, 'crew')}/actions"

    def crew_measures(self, crew: str) -> str:
        """Return the key of a crew's `CrewMeasures`."""
        return f"{self.prefix}crew/{check_name(crew, 'crew')}/measures"

    # ------------------------------------------------------------ parse

    def _chunks(self, key: str, count: int) -> list[str]:
        """Return the chunks after the prefix, or an empty list if their number differs."""
        if not key.startswith(self.prefix):
            return []
        chunks = key[len(self.prefix) :].split("/")
        return chunks if len(chunks) == count else []

    def _named(self, key: str, first: str) -> str | None:
        match self._chunks(key, 2):
            case [head, name] if head == first and is_name(name):
                return name
        return None

    def parse_in(self, key: str) -> In | None:
        """Return the writer and the kind of message, or None if it is not a key that agents write."""
        match self._chunks(key, 3):
            case ["in", agent, kind] if kind in IN_KINDS and is_name(agent):
                return In(agent, IN_KINDS[kind])
        return None

    def parse_stray(self, key: str) -> str | None:
        """Return the agent of a key below `in` or `user`, empty if that is no name; None if it is another key.

        Call it for keys that are neither of those that agents write nor that of a `UserInput`.
        """
        head, _, rest = key.removeprefix(self.prefix).partition("/")
        if not key.startswith(self.prefix) or head not in {"in", "user"}:
            return None
        agent = rest.partition("/")[0]
        return agent if is_name(agent) else ""

    def parse_out(self, key: str) -> Out | None:
        """Return the addressee and the kind of message, or None if it is another key."""
        match self._chunks(key, 3):
            case ["out", agent, kind] if kind in OUT_KINDS and is_name(agent):
                return Out(agent, OUT_KINDS[kind])
        return None

    def parse_token(self, key: str) -> Token | None:
        """Return the owner of the token, or None if it is another key."""
        match self._chunks(key, 5):
            case ["in", agent, "alive", role, instance] if role in ROLES and is_name(agent) and is_hex(instance):
                return Token(agent, ROLES[role], instance)
        return None

    def parse_claim(self, key: str) -> Claim | None:
        """Return the claim of a simulator on the world, or None."""
        match self._chunks(key, 3):
            case ["alive", since, instance] if is_hex(since) and is_hex(instance):
                return Claim(int(since, 16), instance)
        return None

    def parse_join(self, key: str) -> str | None:
        """Return the agent that joins, or None if it is another key."""
        return self._named(key, "join")

    def parse_leave(self, key: str) -> str | None:
        """Return the agent that leaves, or None if it is another key."""
        return self._named(key, "leave")

    def parse_user(self, key: str) -> str | None:
        """Return the agent that a `UserInput` is for, or None if it is another key."""
        return self._named(key, "user")

    def parse_body(self, key: str) -> str | None:
        """Return the agent of a `Body`, or None if it is another key."""
        return self._named(key, "body")

    def parse_ctl(self, key: str) -> Control | None:
        """Return the control verb and the agent in the key, or None if there is no such verb."""
        match self._chunks(key, 3) or self._chunks(key, 2):
            case ["ctl", verb] if verb in VERBS:
                return Control(VERBS[verb])
            case ["ctl", verb, agent] if VERBS.get(verb) in AGENT_VERBS and is_name(agent):
                return Control(VERBS[verb], agent)
        return None

    def parse_state(self, key: str) -> int | None:
        """Return the number of the part of the `WorldState`, or None if it is another key."""
        match self._chunks(key, 2):
            case ["state", part] if part.isascii() and part.isdigit() and len(part) <= 6:
                return int(part)
        return None

    def parse_crew(self, key: str) -> str | None:
        """Return the crew whose actions the key carries, or None if it is another key."""
        match self._chunks(key, 3):
            case ["crew", crew, "actions"] if is_name(crew):
                return crew
        return None


def parse_alive(key: str) -> str | None:
    """Return the world whose simulator is alive, or None if it is another key."""
    match key.split("/"):
        case ["iw", "v1", world, "alive"] if is_name(world):
            return world
    return None
