from __future__ import annotations

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Control, In, Keys, Out, Token, parse_alive
from intellwheels_schemas.messages import Delete, Pause
from tests.every_case import every_case

HEX = "5f0c2a9be1d84377"


def test_every_key_is_as_the_contract_says() -> None:
    keys = Keys("lab")
    assert keys.join("a") == "iw/v1/lab/join/a"
    assert keys.leave("a") == "iw/v1/lab/leave/a"
    assert keys.actions("a") == "iw/v1/lab/in/a/actions"
    assert keys.say("a") == "iw/v1/lab/in/a/say"
    assert keys.pose("a") == "iw/v1/lab/in/a/pose"
    assert keys.token("a", "both", HEX) == f"iw/v1/lab/in/a/alive/both/{HEX}"
    assert keys.user("a") == "iw/v1/lab/user/a"
    assert keys.measures("a") == "iw/v1/lab/out/a/measures"
    assert keys.power("a") == "iw/v1/lab/out/a/power"
    assert keys.error("a") == "iw/v1/lab/out/a/error"
    assert keys.body("a") == "iw/v1/lab/body/a"
    assert keys.state(3) == "iw/v1/lab/state/3"
    assert (keys.map, keys.event, keys.clock, keys.alive) == tuple(
        f"iw/v1/lab/{name}" for name in ("map", "event", "clock", "alive")
    )
    assert keys.ctl("pause") == "iw/v1/lab/ctl/pause"
    assert keys.ctl("take", "a") == "iw/v1/lab/ctl/take/a"
    assert keys.ctl_of("pause", Pause()) == "iw/v1/lab/ctl/pause"
    assert keys.ctl_of("delete", Delete(agent="a")) == "iw/v1/lab/ctl/delete/a"
    for verb, agent in (("take", None), ("pause", "a")):
        with pytest.raises(ValueError, match=f"agent for ctl/{verb}"):
            keys.ctl(verb, agent)  # type: ignore[arg-type]
    assert keys.crew_actions("c") == "iw/v1/lab/crew/c/actions"
    assert keys.crew_measures("c") == "iw/v1/lab/crew/c/measures"


def test_what_was_made_is_taken_apart_again() -> None:
    keys = Keys()
    assert keys.parse_in(keys.pose("a")) == In("a", "pose")
    assert keys.parse_out(keys.error("a")) == Out("a", "error")
    assert keys.parse_token(keys.token("a", "mind", HEX)) == Token("a", "mind", HEX)
    assert keys.parse_token(keys.token("a", "both", HEX, "c")) == Token("a", "both", HEX, "c")
    assert keys.parse_join(keys.join("a")) == "a"
    assert keys.parse_leave(keys.leave("a")) == "a"
    assert keys.parse_user(keys.user("a")) == "a"
    assert keys.parse_body(keys.body("a")) == "a"
    assert keys.parse_ctl(keys.ctl("seek")) == Control("seek")
    assert keys.parse_ctl(keys.ctl("take", "a")) == Control("take", "a")
    assert keys.parse_ctl("iw/v1/main/ctl/take") == Control("take")
    assert keys.parse_state(keys.state(12)) == 12
    assert keys.parse_crew(keys.crew_actions("c")) == "c"
    assert parse_alive(keys.alive) == "main"


@every_case(
    "key",
    [
        "iw/v1/main/in/*/actions",
        "iw/v1/main/in/**",
        "iw/v1/main/in/a",
        "iw/v1/main/in/a/actions/x",
        "iw/v1/main/in/A/actions",
        "iw/v1/main/in//actions",
        "iw/v1/main/in/a/measures",
        "iw/v1/other/in/a/actions",
        "iw/v2/main/in/a/actions",
        "iw/v1/main/out/a/actions",
        "xiw/v1/main/in/a/actions",
        "",
    ],
)
def test_key_of_nobody_is_nobodys(key: str) -> None:
    assert Keys().parse_in(key) is None


def test_other_keys_of_nobody_are_nobodys() -> None:
    keys = Keys()
    assert keys.parse_out("iw/v1/main/out/*/measures") is None
    assert keys.parse_token(f"iw/v1/main/in/a/alive/both/{HEX.upper()}") is None
    assert keys.parse_token(f"iw/v1/main/in/a/alive/king/{HEX}") is None
    assert keys.parse_join("iw/v1/main/join/*") is None
    for key in ("explode", "explode/a", "pause/a", "take/A", "take/*", "take/a/b"):
        assert keys.parse_ctl(f"iw/v1/main/ctl/{key}") is None
    assert keys.parse_state("iw/v1/main/state/-1") is None
    assert keys.parse_state("iw/v1/main/state/²") is None
    assert keys.parse_crew("iw/v1/main/crew/c/measures") is None
    assert keys.parse_crew_measures(keys.crew_measures("c")) == "c"
    assert keys.parse_crew_query(keys.crew_join("c")) == ("c", "join")
    assert keys.parse_crew_query(keys.crew_leave("c")) == ("c", "leave")
    assert keys.parse_crew_query(keys.crew_actions("c")) is None
    assert keys.parse_token(f"{keys.token('a', 'both', HEX)}/*") is None
    assert parse_alive("iw/v1/*/alive") is None


@pytest.mark.parametrize("name", ["*", "a b", "@a", "", "a/b"])
def test_no_key_is_made_of_what_is_no_name(name: str) -> None:
    with pytest.raises(WireError):
        Keys(name)
    with pytest.raises(WireError):
        Keys().measures(name)


def test_no_token_is_made_of_what_is_no_instance() -> None:
    with pytest.raises(ValueError, match="16 hex digits"):
        Keys().token("a", "both", "1")


@every_case(
    ("key", "agent"),
    [
        ("in/a/acton", "a"), ("in/a", "a"), ("in/a/actions/x", "a"), ("in/A/actions", ""), ("in", ""),
        ("user/a/b", "a"), ("user/*", ""), ("out/a/measures", None), ("state/0", None),
    ],
)  # fmt: skip
def test_key_that_nobody_reads_says_whom_it_may_be_of(key: str, agent: str | None) -> None:
    assert Keys("lab").parse_stray(f"iw/v1/lab/{key}") == agent
    assert Keys("other").parse_stray(f"iw/v1/lab/{key}") is None
