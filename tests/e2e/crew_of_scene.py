"""Hosts the cast of a scene as one crew: `python -m tests.e2e.crew_of_scene SCENE ENDPOINT WORLD ENCODING`."""

from __future__ import annotations

import sys

from intellwheels_agents import minds
from intellwheels_agents.crew_harness import CrewMember
from intellwheels_agents.crew_peer import run_crew
from intellwheels_agents.options import Options
from intellwheels_agents.robot_document import equipped, joining, split_options
from intellwheels_maps import robot, scene
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.link import Link
from intellwheels_schemas.names import new_hex
from intellwheels_schemas.process import stop_on_signals


def main(name: str, endpoint: str, world: str, encoding: str) -> int:
    """Run until the simulator is gone or a signal comes."""
    stop, instance, members = stop_on_signals(), new_hex(), []
    for one in scene(name).cast:
        of_robot, of_mind = split_options({each.name: each.value for each in one.option})
        source = minds.find(one.mind or "")
        body = source.equip(equipped(robot(one.robot or ""), of_robot), Options(of_mind))
        document = joining(body, agent=one.name, role="both", instance=instance, place=one.place, barrier=None)
        members.append(CrewMember(document, source.make, of_mind))
    return run_crew(
        "cast", instance, members, where=Link(world=world, connect=(endpoint,)),
        encoding=Encoding[encoding.upper()], retry_for=60.0, stop=stop,
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
