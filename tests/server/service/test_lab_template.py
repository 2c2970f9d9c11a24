from __future__ import annotations

from intellwheels_schemas.lab_rules import check_lab
from intellwheels_server.service.lab_template import new_lab


def test_new_lab_gives_each_student_names_of_its_own_and_real_chairs_a_certificate() -> None:
    lab = new_lab("room3", 20, ["real1"])
    check_lab(lab, "Lab")
    names = [identity.name for identity in lab.identity]
    assert names[:4] == ["simulator", "teacher", "recorder", "student1"]
    assert names[-2:] == ["student20", "bridge-real1"]
    assert [identity.name for identity in lab.identity if identity.certificate] == ["bridge-real1"]
    assert {may.agents for identity in lab.identity if identity.name == "student3" for may in identity.may} == {
        ("st3-*",)
    }
    assert not any(may.role == "mind" for identity in new_lab("x", 1, []).identity for may in identity.may)
