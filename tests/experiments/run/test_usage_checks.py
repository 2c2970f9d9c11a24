from __future__ import annotations

import socket
from argparse import Namespace
from typing import Any

import pytest

from intellwheels_experiments.run import usage_checks
from intellwheels_experiments.run.usage_checks import (
    check_cast_of,
    check_connection,
    check_speed,
    first_agent,
    narrow_warnings,
)
from intellwheels_maps import floor, scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Bridge, Cast, Scene


def options(**given: Any) -> Namespace:
    plain: dict[str, Any] = {
        "world": "main",
        "listen": [],
        "connect": [],
        "config": None,
        "view": False,
        "view_port": 8080,
    }
    return Namespace(**{**plain, "mind": [], "option": [], "command": [], "scene": "figure6", **given})


def test_ports_are_checked_and_the_option_of_this_command_is_named() -> None:
    check_connection(options())
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(WireError, match=f"^--view-port: expected a free port, got {port}, .* --view-port 0"):
            check_connection(options(view=True, view_port=port))
        with pytest.raises(ConnectionError, match=r"the port is in use.*--listen"):
            check_connection(options(listen=[f"tcp/127.0.0.1:{port}"]))
    with pytest.raises(WireError, match=r"^--connect: expected an endpoint"):
        check_connection(options(connect=["lab"]))


def test_speed_is_that_of_a_run_in_real_time() -> None:
    check_speed(5.0, "realtime")
    check_speed(1.0, "lockstep")
    with pytest.raises(WireError, match=r"^--speed: expected with --pace realtime, got pace free$"):
        check_speed(5.0, "free")


def test_only_what_a_user_wrote_is_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(usage_checks, "check_cast", lambda _scenes, _folder, option: asked.append(option))
    for given in (
        options(),
        options(scene="./mine.xml"),
        options(mind=["a=b"]),
        options(mind=["a=b"], option=["a.b=c"]),
        options(command=["a=b"]),
    ):
        check_cast_of([scene("figure6")], None, given)
    assert asked == ["SCENE", "--mind", "--mind or --option", "--command"]


def test_a_scene_without_agents_has_no_first_one() -> None:
    assert first_agent(scene("figure6")) == "chair1"
    with pytest.raises(WireError, match=r"^SCENE: empty: expected a Cast, got none$"):
        first_agent(Scene(format="iw.v1", name="empty", map="room"))


def test_agents_that_start_where_they_cannot_turn_are_named_but_no_real_ones() -> None:
    tight = floor("crossing")
    cast = tuple(Cast(name=name, robot="rear-wheel", mind="drive", place="south-side") for name in ("a", "b"))
    bridge = Bridge(agent="b")
    chosen = Scene(format="iw.v1", name="s", map="crossing", cast=cast, bridge=(bridge,))
    assert narrow_warnings(chosen, tight, None) == [
        "agent 'a': place 'south-side' is too narrow: it needs 0.905 m to turn on the spot, got 0.800 m to Wall[0]"
    ]
    assert narrow_warnings(scene("figure6"), floor("room"), None) == []
