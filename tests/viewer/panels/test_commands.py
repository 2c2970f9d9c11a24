"""The commands that the page prints; `tests/e2e/test_printed_commands.py` runs them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from intellwheels_schemas.defaults import ENDPOINT
from intellwheels_viewer.panels.commands import agent_command, is_local, run_command
from tests.viewer.panels import made_up


def test_an_agent_is_told_only_what_is_not_the_default() -> None:
    assert agent_command(made_up.snapshot()) == "iw-agent avoid --name chair1"
    elsewhere = replace(made_up.snapshot(), endpoint="tcp/10.0.0.5:7448", world="ward")
    assert agent_command(elsewhere) == "iw-agent avoid --name chair1 --connect tcp/10.0.0.5:7448 --world ward"
    assert agent_command(replace(elsewhere, endpoint="/my files/z.json5", world="main")) == (
        "iw-agent avoid --name chair1 --config '/my files/z.json5'"
    )


@pytest.mark.parametrize(
    ("listen", "connect"),
    [
        ("tcp/0.0.0.0:7449", "tcp/127.0.0.1:7449"),
        ("tcp/[::]:7449", "'tcp/[::1]:7449'"),
        ("tcp/10.0.0.5:1", "tcp/10.0.0.5:1"),
    ],
)
def test_who_joins_a_viewer_that_listens_everywhere_gets_an_address_to_connect_to(listen: str, connect: str) -> None:
    waiting = made_up.nothing("no-world", endpoint=listen)
    assert run_command(waiting) == f"iw-run figure6 --pace realtime --connect {connect}"
    assert agent_command(replace(made_up.snapshot(), endpoint=listen)).endswith(f"--connect {connect}")


def test_a_run_listens_where_nobody_is_and_connects_to_a_router() -> None:
    assert run_command(made_up.nothing("no-router")) == f"iw-run figure6 --pace realtime --listen {ENDPOINT}"
    assert run_command(made_up.nothing("no-world")) == f"iw-run figure6 --pace realtime --connect {ENDPOINT}"
    away = made_up.nothing("no-router", endpoint="tcp/lab-pc:7000", world="ward")
    assert run_command(away) == "iw-run figure6 --pace realtime --listen tcp/0.0.0.0:7000 --world ward"


@pytest.mark.parametrize(
    ("endpoint", "local"),
    [("tcp/localhost:1", True), ("tcp/127.0.0.1:1, tcp/[::1]:2", True), ("tcp/10.0.0.1:1", False)],
)
def test_an_address_of_this_machine_is_local(endpoint: str, local: bool) -> None:
    assert is_local(made_up.nothing("no-router", endpoint=endpoint)) is local
