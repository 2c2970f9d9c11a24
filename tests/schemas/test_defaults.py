"""The shared defaults reach the scene, the world and the command line from one place."""

from __future__ import annotations

from intellwheels_schemas import defaults
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Scene
from intellwheels_server.server_options import options_of, parser
from intellwheels_server.world import Setup
from tests.server.worlds import floor_of

SHARED = {
    "seed": defaults.SEED,
    "period": defaults.PERIOD,
    "say_range": defaults.SAY_RANGE,
    "say_walls": defaults.SAY_WALLS,
    "say_loss": defaults.SAY_LOSS,
    "say_delay": defaults.SAY_DELAY,
}


def test_scene_world_and_command_line_have_the_same_defaults() -> None:
    scene = Scene(format="iw.v1", name="test", map="room")
    started = options_of(parser().parse_args(["--world", defaults.WORLD]))[0]
    for name, value in SHARED.items():
        assert getattr(scene, name) == value
        assert getattr(Setup(floor=floor_of()), name) == value
        assert getattr(started.setup, name) == value
    assert started.setup.say_limit == Setup(floor=floor_of()).say_limit == defaults.SAY_LIMIT
    assert started.setup.command_timeout == Setup(floor=floor_of()).command_timeout == defaults.COMMAND_TIMEOUT
    assert (started.grace, started.deadline) == (defaults.GRACE, defaults.ELASTIC_DEADLINE)


def test_world_has_one_default_name() -> None:
    assert Keys().world == Link().world == defaults.WORLD


def test_help_shows_the_defaults() -> None:
    shown = " ".join(parser().format_help().split())
    for text in (
        "(default: the scene's, or 0.05)",
        "(default: 100)",
        "(default: the scene's, or 8)",
        "(default: strict 10, elastic 1)",
    ):
        assert text in shown
