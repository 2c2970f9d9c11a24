"""The document of a new lab: a simulator, a teacher, students, and real chairs. Pure."""

from __future__ import annotations

from collections.abc import Sequence

from intellwheels_schemas.messages import Identity, Lab, May


def new_lab(name: str, students: int, chairs: Sequence[str]) -> Lab:
    """Return a lab to start from.

    Args:
        name: Name of the lab.
        students: How many students it has. `student3` may have the agents `st3-*`, look at everything, and steer these.
        chairs: Names of the real chairs. The identity `bridge-NAME` needs a certificate; the teacher runs the minds.
    """
    minds = (May(role="mind", agents=tuple(chairs)),) if chairs else ()
    return Lab(
        format="iw.v1",
        name=name,
        identity=(
            Identity(name="simulator", may=(May(role="simulator"),)),
            Identity(name="teacher", may=(May(role="operator", agents=("*",)), *minds)),
            Identity(name="recorder", may=(May(role="recorder"),)),
            *(_student(number) for number in range(1, students + 1)),
            *(_bridge(chair) for chair in chairs),
        ),
    )


def _student(number: int) -> Identity:
    own = (f"st{number}-*",)
    return Identity(name=f"student{number}", may=(May(role="agent", agents=own), May(role="viewer", agents=own)))


def _bridge(chair: str) -> Identity:
    return Identity(name=f"bridge-{chair}", certificate=True, may=(May(role="bridge", agents=(chair,)),))
