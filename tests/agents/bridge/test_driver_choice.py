from __future__ import annotations

import sys
import threading

import pytest

from intellwheels_agents.bridge import main
from intellwheels_agents.bridge.bridge_options import parser
from intellwheels_agents.bridge.driver_choice import DRIVERS, check_values, real_driver
from intellwheels_agents.bridge.hardware_driver import Driver
from intellwheels_maps import robot
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import MODULES

WHERE = {"serial": ("--port", "/dev/null"), "luci": ("--address", "127.0.0.1"), "rnet": ("--channel", "can0")}


def made(driver: str, *words: str) -> Driver:
    given = parser().parse_args([driver, "--name", "chair1", *WHERE[driver], *words])
    return real_driver(given, robot("intellwheels"), threading.Event(), lambda _line: None)


@pytest.mark.parametrize("driver", WHERE)
def test_each_name_makes_its_driver(driver: str) -> None:
    assert type(made(driver)).__name__.lower() == f"{driver}driver"


def test_every_option_belongs_to_one_driver() -> None:
    options = [option for kind in DRIVERS.values() for option in kind.options]
    assert len(options) == len(set(options))
    known = {option for action in parser()._actions for option in action.option_strings}
    assert set(options) <= known
    assert set(WHERE) == {name for name, kind in DRIVERS.items() if kind.where is not None}


@pytest.mark.parametrize("driver", ["luci", "rnet"])
def test_a_missing_extra_says_how_to_get_it(
    driver: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in MODULES[driver]:
        monkeypatch.setitem(sys.modules, module, None)
    assert main([driver, "--name", "chair1", *WHERE[driver]]) == 2
    said = capsys.readouterr().err
    assert f"the driver {driver}: expected the extra {driver} (no module" in said
    assert f"run pip install '.[{driver}]' in the project's folder" in said


def test_driving_by_injection_warns(capsys: pytest.CaptureFixture[str]) -> None:
    made("rnet")
    assert capsys.readouterr().err == ""
    made("rnet", "--allow-injection")
    assert capsys.readouterr().err.startswith("WARNING: --allow-injection sends joystick frames on the CAN bus")


def test_values_of_another_driver_are_checked_too() -> None:
    given = parser().parse_args(["luci", "--name", "chair1", "--address", "a b"])
    with pytest.raises(WireError, match="--address: expected HOST"):
        check_values(given)
