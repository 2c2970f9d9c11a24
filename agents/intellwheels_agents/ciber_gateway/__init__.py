"""`iw-ciber`: lets agents and viewers of the Ciber-Rato simulator, the ancestor of this one, take part in a world.

They speak XML in UDP datagrams. `client_messages` reads what they send, `simulator_messages` writes what they get,
`lab_frame` makes a lab of a map, `ciber_robot` their robot, and `robot_state` keeps what belongs to one. All of these
are pure. `client_socket` has the datagrams of one client, `reception` those of the newcomers, `robot_client` one robot
in the world, and `ciber_process` the world.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Importing one of the pure files alone loads neither the command line nor zenoh.
    from intellwheels_agents.ciber_gateway.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
