"""Every kind of the contract has its file, and a new kind touches no second place."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_maps import floor
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import SENSOR_RECORDS, sensors_of
from intellwheels_server.world.sensors.catalogue import KINDS, example_sensors, find_kinds

# What somebody who adds a kind writes: two records with a field each, and one file.
RECORDS = '''
class Nose(Record, frozen=True, kw_only=True):
    """How strongly it smells."""

    id: Id
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class NoseReading(Record, frozen=True, kw_only=True):
    """The strength of a smell."""

    id: Id
    tick: Tick | None = None
    strength: Share
    warm: bool = False


'''
KIND = '''
"""Noses smell how fast the body moves."""

from dataclasses import dataclass

from numba import njit

from intellwheels_schemas.messages import Nose, NoseReading
from {kernels} import rows
from {kernels}.sample_schedule import BODY, due_slot
from {sensors}.kind import Kind


@njit(error_model="numpy")
def _take(tick, numbers, schedule, samples):
    for sensor in range(schedule.shape[0]):
        slot = due_slot(schedule, sensor, tick, 1)
        if slot >= 0:
            samples[slot] = min(abs(numbers[rows.SPEED, schedule[sensor, BODY]]), 1.0)


@dataclass(frozen=True)
class NoseBlock:
    schedule: object

    def take(self, tick, view, samples):
        _take(tick, view.numbers, self.schedule, samples)


class NoseKind(Kind):
    declaration = Nose

    def compile(self, _fitted, schedule, /):
        return NoseBlock(schedule)

    def reading(self, sensor, tick, sample):
        return NoseReading(id=sensor.declaration.id, tick=tick, strength=sample[0])
'''
# Adds the kind in memory before anything else is imported, then asks every place that must know all kinds.
PROGRAM = """
import importlib.util
import sys
from importlib.machinery import PathFinder
from pathlib import Path

messages, sensors, records, folder = sys.argv[1:]

spec = importlib.util.find_spec(messages)
source = Path(spec.origin).read_text(encoding="utf-8")
for old, new in (
    ("class Robot(Record", records + "class Robot(Record"),
    ("    truth: tuple[Truth, ...] = ()\\n", "    truth: tuple[Truth, ...] = ()\\n    nose: tuple[Nose, ...] = ()\\n"),
    (
        "    truth: tuple[TruthReading, ...] = ()\\n",
        "    truth: tuple[TruthReading, ...] = ()\\n    nose: tuple[NoseReading, ...] = ()\\n",
    ),
):
    assert source.count(old) == 1, old
    source = source.replace(old, new)
module = importlib.util.module_from_spec(spec)
sys.modules[messages] = module
exec(compile(source, spec.origin, "exec"), module.__dict__)


class WithFolder:
    # Finds the files of the folder in the package of sensors, whoever imports it first.

    @staticmethod
    def find_spec(name, path=None, target=None):
        if name != sensors:
            return None
        found = PathFinder.find_spec(name, path, target)
        found.submodule_search_locations.append(folder)
        return found


sys.meta_path.insert(0, WithFolder)

from intellwheels_experiments.conformance.plausible_readings import readings as made_up
from intellwheels_maps import floor, robot
from intellwheels_schemas import generate, rules
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import Actions, Measures, Nose, NoseReading, Robot, Sensors
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_server.world.sensors.catalogue import KINDS, example_sensors
from intellwheels_server.world.warmup import _perceptive
from intellwheels_server.world import Setup, advance, apply, begin, digest, measures
from intellwheels_viewer.panels.readings import Group, Row, groups
from msgspec import structs

assert "nose" in rules.SENSOR_KINDS
assert KINDS[Nose].field == "nose"
assert example_sensors(floor("room"))["nose"] == (Nose(id="nose"),)
assert _perceptive().nose == (Nose(id="nose"),)

smelling = structs.replace(robot("rear-wheel"), nose=(Nose(id="n"), Nose(id="late", every=2, latency=1)))
joining = structs.replace(smelling, format=None)
for encoding in (Encoding.JSON, Encoding.XML):
    assert decode(Robot, encode(joining, encoding), encoding) == joining
state = begin(Setup(floor=floor("room")), run="0" * 16)
state, outputs = apply(state, [Join(agent="a", robot=smelling)])
assert outputs.outcomes[0].code == "ok", outputs
for _ in range(3):
    state, _ = advance(state, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=1.0)}))
found = measures(state, "a")
fast, late = found.sensors.nose
assert (fast.id, fast.tick, late.tick) == ("n", None, 2)
assert fast.strength > late.strength > 0.0
for encoding in (Encoding.JSON, Encoding.XML):
    assert decode(Measures, encode(found, encoding), encoding) == found
digest(state)

group = next(group for group in groups(found) if group.rows[0].id == "n")
assert group.caption == "nose: strength; warm", group.caption
assert group.rows[0].text == f"{fast.strength:.2f}, no", group.rows[0].text

played = made_up(smelling, 7)
assert [one.id for one in played.nose] == ["n", "late"]
answer = structs.replace(found, sensors=played)
assert decode(Measures, encode(answer), Encoding.JSON) == answer

files = generate.generated()
for name in ("xsd", "json", "KEYS.md"):
    assert any(b"Nose" in content for path, content in files.items() if name in path), name
print("ok")
"""


def test_each_declaration_of_the_contract_has_a_kind_of_its_own() -> None:
    assert list(KINDS) == [records.declaration for records in SENSOR_RECORDS.values()]
    assert [kind.field for kind in KINDS.values()] == list(SENSOR_RECORDS)
    assert find_kinds().keys() == KINDS.keys()


def test_examples_are_sensors_of_every_kind() -> None:
    examples = example_sensors(floor("room"))
    robot = Robot(length=1.0, width=1.0, **examples)  # type: ignore[arg-type]
    assert {type(sensor) for _, _, sensor in sensors_of(robot)} == set(KINDS)


@pytest.mark.process
def test_a_new_kind_is_one_file_and_two_records(tmp_path: Path) -> None:
    sensors = find_kinds.__module__.rpartition(".")[0]
    kernels = sensors.rpartition(".")[0] + ".kernels"
    kind = KIND.replace("{kernels}", kernels).replace("{sensors}", sensors)
    (tmp_path / "nose.py").write_text(kind, encoding="utf-8")
    arguments = ["intellwheels_schemas.messages", sensors, RECORDS, str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "ok\n"
