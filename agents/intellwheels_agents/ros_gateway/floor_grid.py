"""A map as the grid of ROS (`nav_msgs/OccupancyGrid`). Pure.

Source:
    REP 105 for the frame; the cell (0, 0) is at the origin, rows go along y.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from intellwheels_agents.map_cells import map_cells
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.robot_frames import MAP
from intellwheels_agents.ros_gateway.ros_messages import header, pose_message, time_message
from intellwheels_agents.ros_gateway.ros_types import made_of
from intellwheels_schemas.messages import Map

OCCUPIED: Final = 100


def floor_grid(document: Map, resolution: float, seconds: float) -> Any:
    """Return the grid of a map.

    Args:
        document: The map.
        resolution: Size of a cell, m.
        seconds: Simulated time of the message.
    """
    grid = map_cells(document, resolution)
    info = made_of("nav_msgs/msg/MapMetaData")(
        map_load_time=time_message(0.0),
        resolution=resolution,
        width=grid.columns,
        height=grid.rows,
        origin=pose_message(PlanePose(grid.west, grid.south, 0.0)),
    )
    data = np.frombuffer(grid.cells, dtype=np.int8) * np.int8(OCCUPIED)
    return made_of("nav_msgs/msg/OccupancyGrid")(header=header(MAP, seconds), info=info, data=data)
