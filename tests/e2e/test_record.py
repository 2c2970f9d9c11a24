"""`iw-record` in a world: simulator, chair, recorder, and readers that are not ours. Real processes."""

from __future__ import annotations

import json
import re
import signal
import struct
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import foxglove.layouts
import pytest
import yaml
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from tests.e2e.stage import DEADLINE, Stage

RECORDER = "intellwheels_agents.record_gateway"


def recorder(stage: Stage, *words: str) -> str:
    child = stage.start("record", RECORDER, *words, "--connect", stage.endpoint, "--world", stage.world)
    stage.line(child, "ready")
    return child


def read(path: Path) -> dict[str, list[tuple[int, bytes]]]:
    """Return the messages of a whole recording by topic: log time and data."""
    found: dict[str, list[tuple[int, bytes]]] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            assert schema.encoding == ("jsonschema" if channel.message_encoding == "json" else "protobuf")
            found.setdefault(channel.topic, []).append((message.log_time, message.data))
    return found


def read_killed(path: Path) -> int:
    """Return how many messages a recording without an end has."""
    count = 0
    with path.open("rb") as file:
        try:
            for _ in NonSeekingReader(file).iter_messages(log_time_order=False):
                count += 1
        except EndOfFile:
            return count
    raise AssertionError("the recording has an end")


def complaints(path: Path) -> list[str]:
    """Return what the doctor of another project finds wrong with a file of MCAP, and the summary."""
    program = Path(sys.executable).with_name("pymcap-cli")
    done = subprocess.run(
        [program, "doctor", path, "--format", "jsonl"], capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert lines, done.stderr
    assert lines[-1]["complete"]
    return [line["message"] for line in lines[:-1] if line["severity"] != "info"]


PANELS = {
    json.loads(getattr(foxglove.layouts, name)().to_json())["panelType"]
    for name in dir(foxglove.layouts)
    if name.endswith("Panel") and name not in ("BasePanel", "Panel")
}
"""Types of panels, by Foxglove's library."""
IN_FILES = {"3D": "ThreeDee", "RosOut": "Log"}
"""The types that have another name in the files of layouts that Foxglove exports."""


def shown_by_the_layout() -> set[str]:
    """Return the topics that the panels of the layout show."""
    layout = json.loads(files("intellwheels_agents.record_gateway").joinpath("layout.json").read_text())
    panels = layout["configById"]
    types = {name.partition("!")[0] for name in panels}
    assert {IN_FILES.get(name, name) for name in types} <= PANELS
    assert types.isdisjoint(IN_FILES.values())
    words = json.dumps([panel for name, panel in panels.items() if not name.startswith("Publish!")])
    return {topic.partition(".")[0] for topic in re.findall(r'"(/[^"]+)"', words)}


def ticks(messages: list[tuple[int, bytes]]) -> list[int]:
    return [json.loads(data)["Tick"] for _, data in messages]


@pytest.mark.process
def test_a_world_is_recorded_and_no_bytes_of_a_peer_stop_the_recorder(stage: Stage) -> None:
    stage.server("--map", "ward", "--pace", "realtime", "--log", str(stage.folder / "run.jsonl"))
    stage.agent("chair1", "avoid", robot="intellwheels")
    path = stage.folder / "run.mcap"
    child = recorder(stage, str(path))
    with stage.peer() as peer:
        forged = {"Run": "0123456789abcdef", "Tick": 7, "Time": 1.0, "State": "running", "Pace": "free"}
        peer.put("clock", {**forged, "Hash": "0123456789abcdef", "Stamp": 1e12})
        hostile = (b"", b"\xff" * 50, b"{", b'{"Run":"0000000000000000","Tick":0}', b"[" * 100_000, bytes(2_000_000))
        for key in (
            "state/0",
            "state/99999999",
            "clock",
            "map",
            "event",
            "body/chair1",
            "out/chair1/measures",
            "in/x/y",
        ):
            for data in hostile:
                peer.put(key, data)
        for number in range(1000):
            peer.put(f"user/c{number}", b"{}")
        # A second of wall time is lost to the forged clock, and twenty ticks are seen.
        events = peer.hear("out/chair1/measures")
        stage.wait(lambda: len(events) > 45 or None, "measures", DEADLINE)
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0
    line = stage.line(child, "recorded")
    found = read(path)
    assert int(line["refused"]) > 0
    assert len({json.loads(data)["Run"] for _, data in found["/iw/clock"]}) == 2
    assert {
        "/tf",
        "/scene",
        "/wedges",
        "/grid",
        "/chair1/pose",
        "/chair1/truth",
        "/iw/clock",
        "/iw/map",
    } <= found.keys()
    assert shown_by_the_layout() <= found.keys()
    recorded = ticks(found["/iw/state"])
    assert len(found["/tf"]) == int(line["ticks"]) > 20
    # The forged clock costs a second of ticks, in which the true run counts as past; they are reported.
    assert int(line["ticks"]) + int(line["missed"]) == max(recorded) - min(recorded) + 1


@pytest.mark.process
def test_a_killed_recorder_leaves_what_it_had_a_second_before(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1")
    path = stage.folder / "run.mcap"
    child = recorder(stage, str(path))
    # The file grows once a second; what it has first may be little.
    sizes = {path.stat().st_size}

    def grew_twice() -> bool | None:
        sizes.add(path.stat().st_size)
        return len(sizes) > 2 or None

    stage.wait(grew_twice, "a second of messages", DEADLINE, unless=child)
    stage.signal(child, signal.SIGKILL)
    assert stage.exit(child) == -signal.SIGKILL
    assert read_killed(path) > 40


@pytest.mark.process
def test_a_log_becomes_a_recording_of_every_tick_in_files_of_a_size(stage: Stage) -> None:
    log = stage.folder / "run.jsonl"
    stage.server("--map", "ward", "--pace", "lockstep", "--expect", "chair1", "--log", str(log))
    with stage.peer() as peer:
        stage.agent("chair1", "drive", "--option", "left=0.4", "--option", "right=0.3", robot="corridor-chair")
        peer.tick(120)
        last = peer.ctl("pause")["Tick"]
        peer.ctl("quit")
    assert stage.exit("server") == 0
    path, bag = stage.folder / "log.mcap", stage.folder / "bag"
    child = stage.start("record", RECORDER, str(path), "--ros2", str(bag), "--from", str(log), "--rotate", "0.1")
    line = stage.line(child, "recorded")
    assert stage.exit(child) == 0
    assert (line["ticks"], line["missed"], line["refused"]) == (str(last + 1), "0", "0")
    files_of = [path, *(stage.folder / f"log-{number}.mcap" for number in range(2, int(line["files"]) + 1))]
    assert len(files_of) > 1
    found = [read(file) for file in files_of]
    assert all({"/scene", "/grid", "/iw/map"} <= one.keys() for one in found)
    states = [tick for one in found for tick in ticks(one["/iw/state"])]
    assert sorted(set(states)) == list(range(last + 1))
    assert [complaint for file in (files_of[0], *bag.glob("*.mcap")) for complaint in complaints(file)] == []
    check_bag(bag, int(line["bag_messages"]), last)


def check_bag(bag: Path, messages: int, last: int) -> None:
    """Check that a bag has every tick of a run, by the reader of rosbags and by what the bag says of itself."""
    told = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (told["storage_identifier"], told["message_count"]) == ("mcap", messages)
    types = get_typestore(Stores.ROS2_KILTED)
    found: dict[str, list[Any]] = {}
    with Reader(bag) as reader:
        for connection, _, data in reader.messages():
            found.setdefault(connection.topic, []).append(types.deserialize_cdr(data, connection.msgtype))
    assert {"/clock", "/map", "/tf", "/tf_static", "/diagnostics", "/chair1/odom"} <= found.keys()
    # The period follows from the first tick, so there is none of tick 0.
    stamps = [round(odom.header.stamp.sec * 20 + odom.header.stamp.nanosec / 5e7) for odom in found["/chair1/odom"]]
    assert stamps == list(range(1, last + 1))
    assert found["/chair1/odom"][-1].twist.twist.linear.x > 0.1


SILENCE = 12.0
"""Seconds without a message after which a page subscribes again: `iw-record` has sent everything four times by then."""


class Page:
    """A page of Foxglove: its protocol, written from its description."""

    def __init__(self, address: str) -> None:
        self.socket: ClientConnection = connect(address, subprotocols=[Subprotocol("foxglove.sdk.v1")], max_size=None)
        self.channels: dict[str, int] = {}
        self._topics: list[str] = []

    def subscribe(self, topic: str) -> None:
        while topic not in self.channels:
            self._receive()
        self._topics.append(topic)
        number = len(self._topics)
        self._send({"op": "subscribe", "subscriptions": [{"id": number, "channelId": self.channels[topic]}]})

    def message(self) -> bytes:
        while True:
            try:
                data = self._receive(SILENCE)
            except TimeoutError:
                # On a busy machine the server of the library has lost a subscription twice. It is made once more.
                self.subscribe(self._topics[-1])
                data = self._receive()
            if data is not None:
                return data

    def advertise(self, topic: str) -> None:
        channel = {"id": 1, "topic": topic, "encoding": "json", "schemaName": ""}
        self._send({"op": "advertise", "channels": [channel]})

    def publish(self, data: bytes) -> None:
        self.socket.send(struct.pack("<BI", 1, 1) + data)

    def _send(self, words: dict[str, Any]) -> None:
        self.socket.send(json.dumps(words))

    def _receive(self, timeout: float = DEADLINE) -> bytes | None:
        data = self.socket.recv(timeout=timeout)
        if isinstance(data, bytes):
            return data[13:] if data[0] == 1 else None
        words = json.loads(data)
        if words["op"] == "advertise":
            self.channels |= {channel["topic"]: channel["id"] for channel in words["channels"]}
        return None


@pytest.mark.process
def test_a_page_sees_the_world_and_its_publish_panel_drives_a_chair(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "joystick")
    child = stage.start(
        "record", RECORDER, "--live", "--port", "0", "--connect", stage.endpoint, "--world", stage.world
    )
    page = Page(stage.line(child, "ready")["live"])
    with stage.peer() as peer, page.socket:
        page.subscribe("/scene")
        assert page.message()
        page.advertise("/user/chair1")
        for data in (b"", b"{", b"[]", b'{"Forward": 7}', b'{"Lease": "0123456789abcdef"}', b"\xff" * 1000):
            page.publish(data)

        def drives() -> bool | None:
            page.publish(b'{"linear": {"x": 0.5, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0.1}}')
            return peer.entities()["chair1"].get("Speed", 0.0) > 0.2 or None

        stage.wait(drives, "a chair that drives", DEADLINE)
        peer.entity("chair1", lambda entity: abs(entity.get("Speed", 0.0)) < 0.01)
    assert child in stage.running


@pytest.mark.process
def test_with_take_a_page_drives_a_chair_instead_of_its_mind(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "drive", "--option", "left=0", "--option", "right=0")
    child = stage.start(
        "record", RECORDER, "--live", "--take", "--port", "0", "--connect", stage.endpoint, "--world", stage.world
    )
    page = Page(stage.line(child, "ready")["live"])
    with stage.peer() as peer, page.socket:
        page.subscribe("/scene")
        page.advertise("/user/chair1")

        def drives() -> bool | None:
            page.publish(b'{"Forward": 0.5}')
            return peer.entities()["chair1"].get("Speed", 0.0) > 0.2 or None

        stage.wait(drives, "a chair that drives", DEADLINE)
        peer.event("taken", "chair1")
        peer.event("released", "chair1")
