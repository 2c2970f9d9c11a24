from __future__ import annotations

import msgspec
import pytest

from intellwheels_agents.power_gate import PowerGate
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import Joined, PowerInForce
from intellwheels_schemas.metal_codes import code_of, power_line
from intellwheels_schemas.vectors import KEY, VALID

BRIDGE = VALID["Joined-bridge"]
assert isinstance(BRIDGE, Joined)
RUN = BRIDGE.run


def power(number: int | None, **changes: object) -> PowerInForce:
    plain = PowerInForce(run=RUN, tick=5, seq=number, left_motor=0.5, right_motor=0.5)
    coded = msgspec.structs.replace(plain, code=code_of(KEY, power_line(plain)))
    return msgspec.structs.replace(coded, **changes)


def read(gate: PowerGate, message: PowerInForce) -> PowerInForce | str:
    return gate.read((encode(message), Encoding.JSON))


@pytest.fixture
def gate() -> PowerGate:
    found = PowerGate()
    assert isinstance(BRIDGE, Joined)
    found.joined(BRIDGE)
    return found


def test_power_of_our_simulator_passes(gate: PowerGate) -> None:
    assert read(gate, power(1)) == power(1)
    assert read(gate, power(2)) == power(2)


@pytest.mark.parametrize(
    "changes",
    [{"left_motor": 1.0}, {"right_motor": -0.5}, {"tick": 6}, {"run": "0" * 16}, {"seq": 9}, {"state": "taken"},
     {"code": None}, {"code": "0" * 32}],
)  # fmt: skip
def test_power_that_anybody_changed_does_not_pass(gate: PowerGate, changes: dict[str, object]) -> None:
    assert str(read(gate, power(1, **changes))).startswith("Power.Code: expected the code that our key makes")
    assert read(gate, power(1)) == power(1), "and the real one still does"


def test_copy_of_an_old_power_does_not_pass(gate: PowerGate) -> None:
    read(gate, power(4))
    for seq in (4, 3, None):
        assert "this is a copy" in str(read(gate, power(seq)))


def test_second_reply_to_a_join_has_no_key_and_changes_none(gate: PowerGate) -> None:
    assert isinstance(BRIDGE, Joined)
    gate.joined(msgspec.structs.replace(BRIDGE, key=None))
    assert read(gate, power(1)) == power(1)
    gate.joined(msgspec.structs.replace(BRIDGE, session="0" * 16, key=None))
    assert "no key" in str(read(gate, power(2)))


def test_bytes_of_a_stranger_are_named(gate: PowerGate) -> None:
    assert str(gate.read((b"{", Encoding.JSON))).startswith("Power: expected well-formed JSON")
