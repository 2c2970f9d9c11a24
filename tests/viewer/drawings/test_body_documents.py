from __future__ import annotations

import msgspec

from intellwheels_viewer.drawings.body_documents import BodyDocuments, is_occupied
from tests.viewer.drawings.cast import body


def test_bodies_share_a_look_when_they_look_the_same_and_a_crowd_looks_otherwise() -> None:
    documents = BodyDocuments()
    made = documents.of({"a": body("rear-wheel"), "b": body("rear-wheel"), "c": body("table")}, crowd=False)
    assert made["a"].look == made["b"].look != made["c"].look
    assert (made["a"].is_mobile, made["c"].is_mobile) == (True, False)
    assert documents.of({"a": body("rear-wheel")}, crowd=True)["a"].look not in (made["a"].look, made["c"].look)


def test_a_form_is_found_once_for_each_document_and_anew_for_another() -> None:
    documents, first, other = BodyDocuments(), {"a": body("rear-wheel")}, {"a": body("table")}
    form = documents.of(first, crowd=False)["a"]
    assert documents.of(first, crowd=False)["a"] is form
    assert documents.of(other, crowd=False)["a"].hull.length == 1.6


def test_an_anchored_body_does_not_go_about() -> None:
    assert not BodyDocuments().of({"door": body("door")}, crowd=False)["door"].is_mobile


def test_somebody_sits_in_a_chair_that_a_mind_drives_and_in_a_real_one() -> None:
    chair = body("rear-wheel")
    driven = msgspec.structs.replace(chair, roles=("both",))
    assert [is_occupied(each) for each in (chair, driven, body("rear-wheel", type="real"))] == [False, True, True]
    assert not is_occupied(msgspec.structs.replace(body("person"), roles=("both",)))
    made = BodyDocuments().of({"a": chair, "b": driven}, crowd=False)
    assert made["a"].look != made["b"].look
