"""`iw-ros`: shows a world to ROS 2 nodes, without ROS, and lets them drive a chair.

A node of the middleware rmw_zenoh speaks Zenoh, as a world does. This gateway writes and reads its keys, tokens and
attachments (`rmw_wire`), with messages of ROS in CDR (`ros_types`). Everything else is translated in pure files.

`ros_node` is the only file that knows Zenoh. `ros_types` and the files that import it need rosbags, the extra `ros`.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Importing a pure file alone loads neither the command line nor zenoh.
    from intellwheels_agents.ros_gateway.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
