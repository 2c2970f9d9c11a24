"""The drivers of `iw-bridge`, their options, and what each needs. A new driver is entered here."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from intellwheels_agents.bridge.hardware_driver import Driver
from intellwheels_agents.bridge.luci_driver import LuciDriver
from intellwheels_agents.bridge.luci_options import luci_address
from intellwheels_agents.bridge.pose_source import DRIFT
from intellwheels_agents.bridge.rnet_driver import RnetDriver
from intellwheels_agents.bridge.rnet_options import bus_options, check_bus
from intellwheels_agents.bridge.serial_driver import SerialDriver, check_port
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.messages import Robot

DRIFT_OF_STICK: Final = 0.01
"""Variance of a wheel's travel without encoders, m2 a metre: 10 cm after a metre."""


@dataclass(frozen=True, slots=True)
class DriverKind:
    """What a driver needs.

    Attributes:
        options: Its own options, which the other drivers refuse.
        where: The one that says where the chair is, and must be given; None if it has a default.
        what: What that option names, for an error.
        extra: The extra that it needs, or None.
        hardware: What the chair is, unless `--hardware` says otherwise.
        drift: Variance of the travel of a wheel, m2 a metre, unless `--drift` says otherwise.
        has_motion: Whether it reads an inertial unit.
        has_sonars: Whether it reads sonars.
    """

    options: tuple[str, ...]
    where: str | None = None
    what: str = ""
    extra: str | None = None
    hardware: Literal["real", "simulated"] = "real"
    drift: float = DRIFT
    has_motion: bool = False
    has_sonars: bool = True


DRIVERS: Final = {
    "world": DriverKind(
        ("--lab-world", "--lab-connect", "--lab-place", "--lab-role", "--fix-every", "--fix-noise"),
        hardware="simulated",
    ),
    "serial": DriverKind(("--port", "--baud"), "--port", "a device", "bridge"),
    "luci": DriverKind(
        ("--address", "--joystick-centre", "--reversed-encoder"), "--address", "the host of the unit", "luci",
        has_motion=True,
    ),
    "rnet": DriverKind(
        ("--channel", "--interface", "--can-option", "--allow-injection"), "--channel", "a CAN bus", "rnet",
        drift=DRIFT_OF_STICK, has_sonars=False,
    ),
}  # fmt: skip
"""Every driver, by its name on the command line."""

INJECTION_WARNING: Final = """\
WARNING: --allow-injection sends joystick frames on the CAN bus of the chair. The maker of R-Net has not approved it.
A person must be at the joystick or at the chair's power switch. Raise the wheels off the floor for the first run."""


def check_usage(command: argparse.ArgumentParser, given: argparse.Namespace) -> str | None:
    """End the command if an option does not fit the driver; return what the driver lacks, or None."""
    kind = DRIVERS[given.driver]
    for name, other in DRIVERS.items():
        for option in other.options:
            attribute = option.removeprefix("--").replace("-", "_")
            if name != given.driver and getattr(given, attribute) != command.get_default(attribute):
                command.error(f"{option}: expected with the driver {name}, got {given.driver}")
    if kind.where is not None and getattr(given, kind.where.removeprefix("--")) is None:
        command.error(f"{kind.where}: expected {kind.what} with the driver {given.driver}, got none")
    if given.sensors != "virtual" and not kind.has_sonars:
        command.error(
            f"--sensors: expected virtual with the driver {given.driver}, which reads none, got {given.sensors}"
        )
    lacking = None if kind.extra is None else missing_extra(kind.extra)
    return None if lacking is None else f"the driver {given.driver}: {lacking}"


def check_values(given: argparse.Namespace) -> None:
    """Check the values of the options of real hardware.

    Raises:
        WireError: One is wrong; the text names the option.
    """
    if given.port is not None:
        check_port(given.port)
    if given.address is not None:
        luci_address(given.address)
    if given.driver == "rnet":
        check_bus(given.interface, given.channel)
    bus_options(given.can_option)


def real_driver(given: argparse.Namespace, chair: Robot, stop: threading.Event, tell: Callable[[str], None]) -> Driver:
    """Return the driver of real hardware that the options name; `tell` receives lines for scripts."""
    if given.driver == "luci":
        return LuciDriver(
            luci_address(given.address), chair, stop, centre=given.joystick_centre,
            reversed_wheels=given.reversed_encoder, waiting=_waiting, tell=_dropped,
        )  # fmt: skip
    if given.driver == "rnet":
        if given.allow_injection:
            _log(f"{INJECTION_WARNING}\n")
        return RnetDriver(
            given.interface, given.channel, chair, stop, options=bus_options(given.can_option),
            inject=given.allow_injection, waiting=_waiting, tell=_dropped,
            status=lambda line: tell(f"chair agent={given.name} {line}"),
        )  # fmt: skip
    return SerialDriver(given.port, given.baud, chair.proximity, stop, waiting=_waiting)


def _waiting(reason: str) -> None:
    _log(f"waiting why={reason!r}\n")


def _dropped(reason: str) -> None:
    _log(f"dropped why={reason!r}\n")


def _log(text: str) -> None:
    sys.stderr.write(text)
    sys.stderr.flush()
