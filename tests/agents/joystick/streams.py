"""Streams of Lab Streaming Layer for tests, which stay on this machine. Import it before anything loads liblsl."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from intellwheels_agents.joystick.lsl_source import pylsl_of
from intellwheels_agents.joystick.pygame_source import DeviceError

_FOLDER = tempfile.mkdtemp(prefix="iw-lsl-")
atexit.register(shutil.rmtree, _FOLDER, ignore_errors=True)
CONFIG = Path(_FOLDER) / "lsl_api.cfg"
"""The configuration of liblsl. The session is this process's own, so that other tests see none of its streams."""
CONFIG.write_text(
    "[ports]\nIPv6 = disable\n[multicast]\nResolveScope = machine\nMachineAddresses = {127.0.0.1}\n"
    "AddressesOverride = {127.0.0.1}\n[lab]\nKnownPeers = {127.0.0.1}\n"
    f"SessionID = test-{os.getpid()}\n[log]\nlevel = -3\n"
)
os.environ["LSLAPICFG"] = str(CONFIG)


def pylsl() -> Any:
    """Return pylsl, or skip the test."""
    try:
        return pylsl_of()
    except DeviceError as error:
        pytest.skip(str(error))


def outlet(name: str, kind: str = "EEG", channels: int = 2, *, labels: Sequence[str] = (), text: bool = False) -> Any:
    """Return an outlet: the other end of a stream, until it is deleted."""
    lsl = pylsl()
    info = lsl.StreamInfo(name, kind, channels, 0, lsl.cf_string if text else lsl.cf_float32, "")
    described = info.desc().append_child("channels")
    for label in labels:
        described.append_child("channel").append_child_value("label", label)
    return lsl.StreamOutlet(info)
