"""Bags, read back by rosbags' own reader."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import yaml
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from intellwheels_agents.record_gateway.bag_writer import BagWriter
from intellwheels_agents.record_gateway.record_options import STORAGES
from intellwheels_maps import floor
from tests.agents.record_gateway.test_ros_translator import JSON, KEYS, Both, sensed


@pytest.mark.parametrize("storage", STORAGES)
def test_a_bag_is_read_by_the_reader_of_rosbags(storage: str, tmp_path: Path) -> None:
    both, path = Both(), tmp_path / "bag"
    with closing(BagWriter(path, storage, both.ros)) as bag:
        both.body()
        written = both.clock(1)
        bag.take_map(floor("room"))
        written += both.state(1)
        for measured in sensed(4):
            written += both.clock(measured.tick)
            written += both.state(measured.tick)
            written += both.take(KEYS.measures("c"), measured)
        for entry in written:
            bag.write(entry)
        bag.take(KEYS.clock, b"{", JSON)
    assert bag.messages == len(written) + 1

    told = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (told["version"], told["storage_identifier"], told["message_count"]) == (9, storage, bag.messages)
    assert all((path / name).exists() for name in told["relative_file_paths"])
    topics = {one["topic_metadata"]["name"]: one["topic_metadata"] for one in told["topics_with_message_count"]}
    assert topics["/c/scan"]["type"] == "sensor_msgs/msg/LaserScan"
    (qos,) = topics["/tf_static"]["offered_qos_profiles"]
    assert (qos["durability"], qos["reliability"]) == ("transient_local", "reliable")
    assert topics["/c/scan"]["type_description_hash"].startswith("RIHS01_")

    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_KILTED)) as reader:
        found: list[tuple[str, int, Any]] = [
            (one.topic, time, reader.deserialize(data, one.msgtype)) for one, time, data in reader.messages()
        ]
    assert len(found) == bag.messages
    scans = [(time, message) for topic, time, message in found if topic == "/c/scan"]
    assert [time for time, _ in scans] == sorted({time for time, _ in scans})
    assert all(len(scan.ranges) > 100 for _, scan in scans)
    clocks = [message.clock.nanosec for topic, _, message in found if topic == "/clock"]
    assert clocks == [50_000_000, 100_000_000, 150_000_000, 200_000_000]


def test_a_folder_that_is_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"--ros2: .*exists already"):
        BagWriter(tmp_path, "mcap", Both().ros)
