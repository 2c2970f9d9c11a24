from __future__ import annotations

import viser

from intellwheels_viewer.drawings.label_layout import Picture
from intellwheels_viewer.drawings.labels import REAL, STAND_IN, Labels, cut, is_data, name_of, tags, unlabelled
from intellwheels_viewer.snapshot import USER, Utterance
from tests.viewer.drawings.cast import body, entity, node

CAST = {"a": body("rear-wheel"), "table": body("table"), "door": body("door")}


def test_long_words_are_cut_at_forty_characters() -> None:
    assert cut("x" * 40) == "x" * 40
    assert cut("x" * 41) == "x" * 39 + "…"
    assert cut("two\n  lines") == "two lines"


def test_a_name_has_the_speed_of_what_moves() -> None:
    assert name_of(entity("a", speed=-0.25)) == "a  -0.25 m/s"
    assert name_of(entity("a")) == "a"
    assert name_of(entity("a", speed=1.0), with_speed=False) == "a"
    moving = [entity("a", speed=1.0), entity("b", 3.0, speed=1.0)]
    cast = {"a": body("rear-wheel"), "b": body("rear-wheel")}
    assert [tags(cast, moving, (), 0.0, {"b"})[name].text for name in "ab"] == ["a", "b  1.00 m/s"]


def test_what_goes_has_a_label_above_it_and_furniture_has_not() -> None:
    shown = tags(CAST, [entity("a", 1.0, 2.0), entity("table"), entity("door")], (), 0.0, ())
    assert set(shown) == {"a"}
    assert shown["a"].z > 1.3
    # Above the middle of the chair, which is ahead of its axle.
    assert 1.2 < shown["a"].x < 1.4


def test_the_name_of_a_real_chair_says_so() -> None:
    cast = {"a": body("rear-wheel", type="real"), "b": body("rear-wheel")}
    shown = tags(cast, [entity("a"), entity("b")], (), 0.0, ())
    assert (shown["a"].text, shown["b"].text) == (f"a  {REAL}", "b")
    cast["a"] = body("rear-wheel", type="real", hardware="simulated")
    assert tags(cast, [entity("a")], (), 0.0, ())["a"].text == f"a  {STAND_IN}"


def test_bodies_without_a_label_are_there_for_the_layout_unless_there_are_many() -> None:
    entities = [entity("a", 1.0, 2.0), entity("table", 3.0), entity("door")]
    shown = tags(CAST, entities, (), 0.0, ())
    others = unlabelled(CAST, entities, shown)
    assert [(other.name, other.text) for other in others] == [("table", ""), ("door", "")]
    assert max(others[0].half) > 0.3
    assert unlabelled(CAST, [entity("table")] * 31, ()) == []


def test_words_stand_over_the_name_for_three_seconds() -> None:
    said = [Utterance("a", 10.0, "old"), Utterance("a", 11.0, "new"), Utterance("nobody", 11.0, "hm")]
    now = [tags(CAST, [entity("a")], said, time, ())["a"].text for time in (9.0, 11.0, 13.9, 14.0)]
    assert now == ["a", "“new”\na", "“new”\na", "a"]


def test_above_thirty_bodies_only_the_wanted_and_the_speaking_have_names() -> None:
    many = {f"a{index}": CAST["a"] for index in range(31)}
    entities = [entity(name) for name in many]
    assert set(tags(many, entities, [Utterance("a7", 1.0, "hi")], 1.0, {"a3"})) == {"a3", "a7"}
    assert len(tags(many, entities[:30], (), 1.0, ())) == 30


def test_nodes_are_kept_and_hidden(scene: viser.SceneApi) -> None:
    labels = Labels(scene)
    labels.show(tags(CAST, [entity("a")], (), 0.0, ()), None)
    handle = node(scene, "/labels/a")
    labels.show({}, None)
    assert not handle.visible
    labels.show(tags(CAST, [entity("a", speed=1.0)], (), 0.0, {"a"}), None)
    assert node(scene, "/labels/a") is handle
    assert handle.visible
    assert handle.text == "a  1.00 m/s"


def test_in_a_picture_labels_of_one_place_are_one(scene: viser.SceneApi) -> None:
    cast = {f"c{k}": body("rear-wheel") for k in range(20)}
    picture = Picture((0.0, -10.0, 10.0), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0)
    labels = Labels(scene, "/crowd")
    labels.show(tags(cast, [entity(name) for name in cast], (), 0.0, ()), picture)
    shown = [found for name in cast if (found := node(scene, f"/crowd/{name}")) is not None and found.visible]
    assert any(one.text.endswith(" chairs") for one in shown)
    labels.show(tags(cast, [entity(name, 2.0 * k - 19.0) for k, name in enumerate(cast)], (), 0.0, ()), picture)
    assert node(scene, "/crowd/c9").text == "c9"


def test_what_is_for_programs_is_a_bubble_of_wanted_agents_only() -> None:
    said = [Utterance("a", 10.0, "way 8.2 2.9 -7.6 2")]
    assert tags(CAST, [entity("a")], said, 10.0, ())["a"].text == "a"
    assert "way 8.2" in tags(CAST, [entity("a")], said, 10.0, ("a",))["a"].text
    assert not any(is_data(text) for text in ("door open", "2", "goal 3", "I wait 0.5 s for you", ""))


def test_what_a_user_says_is_a_bubble_above_the_one_it_is_for_or_above_all() -> None:
    cast = {"a": body("rear-wheel"), "b": body("rear-wheel")}
    bodies = [entity("a"), entity("b", 3.0)]
    shown = tags(cast, bodies, (Utterance(USER, 1.0, "hello", "a"),), 1.5, ())
    assert [shown[name].text for name in "ab"] == ["User: \u201chello\u201d\na", "b"]
    both = (Utterance("b", 1.0, "hi"), Utterance(USER, 1.2, "hello"))
    shown = tags(cast, bodies, both, 1.5, ())
    assert [shown[name].text.splitlines()[0] for name in "ab"] == ["User: \u201chello\u201d"] * 2
    assert "\u201chi\u201d" in shown["b"].text
    assert tags(cast, bodies, both, 9.0, ())["a"].text == "a"
