"""The table of sonars: every name of the contract has its figures, and the figures fit together."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import pytest

from intellwheels_schemas.messages import SonarName
from intellwheels_schemas.sonar_devices import DEVICES, PING_PERIOD, SonarDevice, reading_time, sample_time, ticks_for

MODEL = Path(__file__).parents[2] / "server" / "intellwheels_server" / "world" / "MODEL.md"


def test_every_device_of_the_contract_has_figures() -> None:
    assert sorted(DEVICES) == sorted(get_args(SonarName))


def test_beams_are_the_published_ones() -> None:
    beams = {name: device.cone_deg for name, device in DEVICES.items()}
    assert beams == {
        "srf04": 55.0, "srf08": 55.0, "srf10": 72.0, "srf485": 30.0, "srf235": 15.0, "hc-sr04": 15.0,
        "polaroid-6500": 30.0,
    }  # fmt: skip
    assert DEVICES["polaroid-6500"].limit_deg == 42.0


@pytest.mark.parametrize("name", DEVICES)
def test_page_of_the_model_has_the_figures(name: str) -> None:
    device = DEVICES[name]
    (line,) = (line for line in MODEL.read_text(encoding="utf-8").splitlines() if line.startswith(f"| `{name}` |"))
    figures = [cell.replace(" (chosen)", "").strip() for cell in line.split("|")[2:7]]
    assert figures == [
        f"{device.cone_deg:g} deg",
        f"{device.min_range:g} to {device.max_range:g} m",
        f"{1000 * device.ping_period:g} ms",
        f"{346e3 / device.frequency:.2f} mm",
        f"{device.sure_deg:g}, {device.limit_deg:g} deg",
    ]


@pytest.mark.parametrize("device", DEVICES.values(), ids=DEVICES)
def test_figures_fit_together(device: SonarDevice) -> None:
    assert 0.0 < device.min_range < device.max_range
    assert 0.0 < device.sure_deg < device.limit_deg < 90.0
    assert device.sure_deg <= 0.5 * device.cone_deg <= device.limit_deg
    # A ping returns before the next one, and the periods are those of real devices.
    assert 2.0 * device.max_range / 346.0 < device.ping_period
    assert PING_PERIOD <= device.ping_period <= 0.065
    assert device.source


def test_reading_waits_for_the_last_echo_and_the_next_ping_for_both() -> None:
    assert reading_time(3.46) == pytest.approx(0.02)
    assert reading_time(3.46, 0.01, 0.03) == pytest.approx(0.05)
    assert sample_time(None, 3.46, 0.0, 0.0) == PING_PERIOD
    assert sample_time(None, 17.3, 0.0, 0.0) == pytest.approx(0.1)
    assert sample_time("srf08", 6.0, 0.01, 0.03) == pytest.approx(0.085)
    assert [ticks_for(seconds, 0.05) for seconds in (0.0, 0.0499, 0.05, 0.0501)] == [0, 1, 1, 2]
