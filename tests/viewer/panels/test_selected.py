"""The selected body."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import viser

from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.selected import LOG, SelectedPanel, head_html, log_html, sensors_html
from intellwheels_viewer.snapshot import Utterance
from tests.viewer.panels import made_up


def test_nobody_selected_and_somebody_gone_are_said_in_words() -> None:
    assert "Nothing is selected. Click a chair." in head_html(made_up.snapshot(), Choices())
    assert "ghost has left" in head_html(made_up.snapshot(), Choices(selected="ghost"))


def test_head_says_how_it_moves_who_drives_it_and_where_to() -> None:
    page = head_html(made_up.snapshot(), made_up.choices())
    assert "driven by a program, \u201cavoid\u201d" in page
    assert all(word in page for word in ("chair1", ">0.16<", ">18<", "goal 3.25, 1.50"))
    assert "real chair, driven by a program" in head_html(made_up.snapshot(), Choices(selected="chair2"))


def test_sensors_are_rows_under_captions_with_their_units() -> None:
    page = sensors_html(made_up.snapshot(), "chair1")
    assert all(word in page for word in ("proximity, m", "nothing seen", "failed", "2 ticks old", "120034 and"))


def test_each_proximity_sensor_has_a_chart_of_its_own() -> None:
    page = sensors_html(made_up.snapshot(), "chair1")
    assert page.count("iw-spark") == len(made_up.SENSORS)
    assert "last 30 s" in page


def test_no_sensors_are_said_in_words() -> None:
    assert "No sensor readings yet" in sensors_html(made_up.snapshot(), "chair2")


def test_what_it_said_and_what_befell_it_is_one_list_newest_first() -> None:
    page = log_html(made_up.snapshot(), "chair1")
    order = [page.index(word) for word in ("thanks", "coming through", "hit chair3", "chair1 joined")]
    assert order == sorted(order)
    assert "sorry" not in page


def test_what_others_did_to_it_is_in_its_list_and_the_list_is_short() -> None:
    assert "chair1 hit chair3" in log_html(made_up.snapshot(), "chair3")
    talker = tuple(Utterance("chair1", float(k), "and") for k in range(90))
    assert log_html(replace(made_up.snapshot(), utterances=talker), "chair1").count("<li") == LOG


def test_words_of_a_peer_are_text() -> None:
    snapshot, choices = made_up.hostile(), made_up.attacked()
    pages = [head_html(snapshot, choices), sensors_html(snapshot, made_up.ATTACK), log_html(snapshot, made_up.ATTACK)]
    assert not any("<img" in page for page in pages)


def test_plots_are_there_while_there_is_something_to_plot(gui: viser.GuiApi) -> None:
    panel = SelectedPanel(gui)
    panel.show(made_up.snapshot(), made_up.choices())
    assert panel._speeds._plot.visible
    panel.show(made_up.snapshot(), Choices(selected="table1"))
    assert not panel._sensors.content.count("iw-spark")
    panel.show(made_up.snapshot(), Choices())
    assert not any(one.visible for one in (panel._speeds._plot, panel._sensors, panel._log))


def test_a_chart_is_rebuilt_only_when_its_range_changes(gui: viser.GuiApi) -> None:
    panel = SelectedPanel(gui)
    panel.show(made_up.snapshot(), made_up.choices())
    sent: list[str] = []
    plot = cast("Any", panel._speeds._plot)
    queue = type(plot)._queue_update
    try:
        type(plot)._queue_update = lambda handle, name, value: sent.append(name)
        history = {"chair1": made_up.snapshot().history["chair1"][:-1]}
        panel.show(replace(made_up.snapshot(), history=history), made_up.choices())
    finally:
        type(plot)._queue_update = queue
    assert set(sent) <= {"data", "content"}
    assert "data" in sent
