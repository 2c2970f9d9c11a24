"""The points about unusual input, and that such input is valid."""

from __future__ import annotations

import pytest

from intellwheels_experiments.conformance.input_points import HOSTILE, extended
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Heard, Measures
from intellwheels_schemas.names import new_hex
from tests.every_case import every_case
from tests.experiments.conformance.programs import Program, only_failure


class Obeys(Program):
    """Takes what it hears for a command."""

    def on_measures(self, measures: Measures) -> None:
        if not any("kill" in heard.text for heard in measures.message):
            super().on_measures(measures)


def test_program_that_obeys_what_it_hears_fails_that_point_only() -> None:
    failure = only_failure(Obeys())
    assert failure.point == "hostile"
    assert "nothing in answer to" in failure.got


@every_case("text", HOSTILE)
@every_case("encoding", [Encoding.JSON, Encoding.XML])
def test_hostile_texts_are_texts_that_a_simulator_may_send(text: str, encoding: Encoding) -> None:
    heard = Heard(sender="stranger", tick=1, distance=1.0, text=text)
    measures = Measures(run=new_hex(), tick=2, time=0.1, message=(heard,))
    assert decode(Measures, encode(measures, encoding), encoding) == measures


@pytest.mark.parametrize("encoding", [Encoding.JSON, Encoding.XML])
def test_extended_measures_are_refused_strictly_and_read_as_before_otherwise(encoding: Encoding) -> None:
    measures = Measures(run=new_hex(), tick=2, time=0.1)
    payload = extended(encode(measures, encoding), encoding)
    with pytest.raises(WireError):
        decode(Measures, payload, encoding)
    read = decode(Measures, payload, encoding, strict=False)
    assert (read.run, read.tick, read.time) == (measures.run, 2, 0.1)
