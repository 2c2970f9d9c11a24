"""`iw-record`: records a world to MCAP, shows it live to Foxglove, and makes recordings of input logs.

`translator` turns each message of a world into messages of Foxglove and a copy as JSON. `scene_messages` and
`motion_messages` make them, `run_times` dates them and counts missed ticks. All of these are pure.
`message_sinks` writes the file and serves the live view, `world_source` is on the network, `log_source` plays a log.
`ros_translator` makes messages of ROS with the pure files of `iw-ros`, and `bag_writer` a bag of them.
`publish_panel` makes user input of what a page publishes, and `panel_driver` sends it.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Importing one of the pure files alone loads neither the command line nor zenoh.
    from intellwheels_agents.record_gateway.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
