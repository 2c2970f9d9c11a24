"""The rules of a `Lab` that span fields. Pure."""

from __future__ import annotations

import datetime
from typing import Final, get_args

from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import Identity, Lab, LabRole, May

NAMES_AGENTS: Final[frozenset[LabRole]] = frozenset({"agent", "mind", "bridge"})
"""Roles that are nothing without an agent."""
NO_AGENTS: Final[frozenset[LabRole]] = frozenset({"simulator", "recorder"})
"""Roles that are for whole worlds."""


def check_lab(lab: Lab, where: str) -> None:
    """Check that names occur once and that each role has what it needs.

    Raises:
        WireError: The first error, with its place.
    """
    names: set[str] = set()
    for index, identity in enumerate(lab.identity):
        place = f"{where}.Identity[{index}]"
        if identity.name in names:
            raise wrong_value(f"{place}.Name", "each name once", f"{shown(identity.name)} twice")
        names.add(identity.name)
        _check_date(identity.until, f"{place}.Until")
        for number, may in enumerate(identity.may):
            _check_may(may, f"{place}.May[{number}]")


def has_expired(identity: Identity, today: datetime.date) -> bool:
    """Return whether the last day of an identity is over."""
    return identity.until is not None and datetime.date.fromisoformat(identity.until) < today


def _check_date(text: str | None, where: str) -> None:
    try:
        datetime.date.fromisoformat(text or "2000-01-01")
    except ValueError:
        raise wrong_value(where, "a date of the calendar", shown(text)) from None


def _check_may(may: May, where: str) -> None:
    if may.role in NAMES_AGENTS and not may.agents:
        raise wrong_value(f"{where}.Agents", f"the agents of the role {may.role}", "none")
    if may.role in NO_AGENTS and may.agents:
        raise wrong_value(f"{where}.Agents", f"none, as the role {may.role} is for the whole world", may.agents[0])
    if may.verbs and may.role != "operator":
        raise wrong_value(f"{where}.Verbs", f"none, as the role {may.role} has no verbs", may.verbs[0])


LAB_ROLES: Final[tuple[LabRole, ...]] = get_args(LabRole)
"""All roles."""
