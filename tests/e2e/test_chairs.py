"""Real chairs that have electronics of their own: stand-ins for a LUCI unit and for R-Net electronics. Real processes.

CAN frames go by UDP multicast with a hop limit of 0, which keeps them on this machine.
"""

from __future__ import annotations

import signal

import can

from intellwheels_agents.bridge.rnet_frames import Frame, Stick, decode_frame
from tests.e2e.stage import Stage, free_port
from tests.e2e.stand_in import StandIn
from tests.e2e.test_bridge import bridge, mind

WATCHDOG_MS = 5 * 200
"""As in `test_bridge.py`: the stand-ins are processes that may be late on a busy machine."""


START = ("--place", "start", "--resume", "auto")
"""A busy machine may be silent for a second, after which a person would have to press Enter."""


def luci(stage: Stage, *words: str) -> tuple[StandIn, str]:
    """Start a unit with its chair, and a bridge of `real1` to it."""
    chair = StandIn(stage, "chair", "luci_stand_in", "--listen", "127.0.0.1:0")
    return chair, bridge(stage, "real1", "luci", "--address", chair.ready["address"], *START, *words)


def bus_words() -> list[str]:
    """Return a bus of this test's own: a bridge locks its group, whatever the port."""
    port = free_port()
    return [
        "--interface", "udp_multicast", "--channel", f"239.74.{port // 256}.{port % 256}",
        "--can-option", f"port={port}", "--can-option", "hop_limit=0",
    ]  # fmt: skip


def test_a_luci_chair_is_driven_and_a_vanished_unit_stops_it(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    chair, child = luci(stage, "--sensors", "real", "--joystick")
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    chair.command("wall 1.5")
    with stage.peer() as peer:
        chair.line("moving")
        measures = peer.hear("out/real1/measures")
        before = peer.entity("real1", lambda one: one["X"] > 0.1)["X"]
        # Its front sonar is 0.696 ahead of the centre of movement.
        stage.wait(
            lambda: next((True for _, data in list(measures) if b'"Id":"front","Value":0.80' in data), None), "the wall"
        )
        chair.command("vanish 2")
        assert 0 < chair.line("stopped")["silence"] <= WATCHDOG_MS
        peer.event("stale", "real1")
        chair.line("moving")
        peer.event("fresh", "real1")
        peer.entity("real1", lambda one: one["X"] > before + 0.1)
    stage.signal(child, signal.SIGTERM)
    # It sends the centre, and leaves the chair to its user.
    chair.stops_by_command()
    assert stage.exit(child) == 0
    stage.line(chair.child, "source", removed="1")
    counts = stage.line(child, "bridged")
    assert int(counts["reopened"]) >= 1
    assert counts["garbage"] == "0"


def test_a_refused_bridge_takes_no_chair_and_a_killed_one_lets_it_stop(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    chair, child = luci(stage)
    other = stage.start("other-chair", "intellwheels_agents.bridge.luci_stand_in", "--listen", "127.0.0.1:0")
    address = stage.line(other, "ready")["address"]
    # The name is taken, the chair is not.
    second = stage.start(
        "other-bridge", "intellwheels_agents.bridge", "luci", "--address", address, "--name", "real1",
        "--connect", stage.endpoint, "--world", stage.world,
    )  # fmt: skip
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    chair.line("moving")
    assert stage.exit(second) == 4
    assert "already-here" in stage.log(second)
    assert "source" not in stage.log(other)
    stage.signal(child, signal.SIGKILL)
    assert 0 < chair.line("stopped")["silence"] <= WATCHDOG_MS


def test_an_r_net_chair_is_followed_in_silence_and_driven_only_with_the_flag(stage: Stage) -> None:
    server = stage.server("--map", "corridor15m", "--pace", "realtime")
    words = bus_words()
    chair = StandIn(stage, "chair", "rnet_stand_in", *words)
    listener = bridge(stage, "real1", "rnet", *words, *START, "--joystick")
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    with stage.peer() as peer:
        user = peer.hear("user/real1")
        chair.command("stick 30 0")
        chair.line("moving")
        peer.entity("real1", lambda one: one["X"] > 0.3)
        stage.wait(lambda: next((True for _, data in list(user) if b'"Forward":0.3' in data), None), "the joystick")
        chair.command("silence 2")
        chair.command("stick 0 0")
        peer.event("stale", "real1")
        peer.event("fresh", "real1")
        stage.line(listener, "chair", battery="87", speed="100")
        stage.signal(listener, signal.SIGTERM)
        assert stage.exit(listener) == 0
        assert stage.line(listener, "bridged")["injected"] == "0"
        chair.command("count")
        assert chair.line("foreign")["frames"] == 0
    driver = stage.start(
        "driver", "intellwheels_agents.bridge", "rnet", *words, *START, "--allow-injection", "--name", "real1",
        "--connect", stage.endpoint, "--world", stage.world,
    )  # fmt: skip
    with can.Bus(
        interface="udp_multicast", channel=words[3], port=int(words[5].partition("=")[2]), hop_limit=0
    ) as bus:  # fmt: skip

        def injected() -> bool | None:
            got = bus.recv(1.0)
            if got is None:
                return None
            return decode_frame(Frame(got.arbitration_id, bytes(got.data))) == Stick(1, 0.2, 0.0) or None

        stage.wait(injected, "a frame of the bridge", unless=driver)
    chair.line("moving")
    assert "WARNING: --allow-injection" in stage.log(driver)
    # Without the simulator, the bridge falls silent, and the joystick at rest is in force.
    stage.signal(server, signal.SIGKILL)
    chair.line("stopped")
    stage.signal(driver, signal.SIGTERM)
    assert stage.exit(driver) == 0
