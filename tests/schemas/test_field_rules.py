from __future__ import annotations

from intellwheels_schemas.field_rules import assertions, json_rules
from intellwheels_schemas.messages import Actions, ProximityReading, Robot
from intellwheels_schemas.rules import SENSOR_RECORDS, values_of


def test_classes_without_rules_have_no_schema_of_them() -> None:
    assert json_rules(Actions) == []
    assert len(json_rules(Robot)) == 3


def test_each_kind_of_reading_with_a_status_has_its_rule() -> None:
    assert json_rules(ProximityReading)[0]["then"] == {"required": ["Value"]}
    for kind in SENSOR_RECORDS.values():
        if values_of(kind.reading):
            assert json_rules(kind.reading)


def test_numbers_of_a_class_have_no_spaces() -> None:
    found = [rule.test for rule in assertions({"/Actions": Actions}) if rule.context == "/Actions"]
    assert len(found) == 1
    assert "not(contains(@Tick, ' '))" in found[0]
    assert "@Mode" not in found[0]
