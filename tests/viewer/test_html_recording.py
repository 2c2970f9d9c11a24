"""A recording plays what was drawn, as far apart as it was in the run, and holds one run and no panel."""

from __future__ import annotations

import base64
import io
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
import zstandard

from intellwheels_maps import library
from intellwheels_schemas.messages import Body, Entity
from intellwheels_schemas.output_paths import reserved_output
from intellwheels_viewer.html_recording import HtmlRecording
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.stage import Stage

RUN = "0" * 16


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # viser's own use of websockets
        one = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield one
    one.stop()


def snapshot(tick: int, run: str = RUN) -> Snapshot:
    robot = msgspec.structs.replace(library.robot("rear-wheel"), name="chair1")
    return Snapshot(
        phase="live",
        run=run,
        tick=tick,
        time=tick * 0.05,
        floor=library.floor("room"),
        revision=0,
        bodies={"chair1": Body(run=run, tick=0, robot=robot)},
        entities=(Entity(name="chair1", x=2.0 + tick / 100, y=2.0, heading=0.0),),
    )


def recorded(server: viser.ViserServer, recording: HtmlRecording, looks: list[Snapshot]) -> list[bool]:
    stage = Stage(server)
    done = []
    for look in looks:
        stage.show(look, ())
        done.append(recording.drawn(look))
    return done


def contents(path: Path) -> dict[str, Any]:
    """Return what viser's player reads out of the file."""
    coded = path.read_text().split('__VISER_EMBED_DATA__="')[1].split('"')[0]
    packed = zstandard.ZstdDecompressor().stream_reader(io.BytesIO(base64.b64decode(coded)[8:])).read()
    length = int.from_bytes(packed[:8], "little")
    return dict(msgspec.msgpack.decode(packed[8 : 8 + length]))


def test_what_was_drawn_is_kept_as_far_apart_as_it_was_in_the_run(server: viser.ViserServer, tmp_path: Path) -> None:
    server.gui.add_text("a panel", "its words")
    recording = HtmlRecording(server, 1.0)
    assert recorded(server, recording, [snapshot(tick) for tick in (20, 24, 30, 40)]) == [False, False, False, True]
    assert recording.length == pytest.approx(1.0)
    with reserved_output(tmp_path / "run.html", overwrite=False) as file:
        size = recording.save(file)
    assert size == (tmp_path / "run.html").stat().st_size
    kept = contents(tmp_path / "run.html")
    assert kept["durationSeconds"] == pytest.approx(1.0)
    moved = [
        at
        for at, message in kept["messages"]
        if message["type"] == "SceneNodeUpdateMessage" and "batched_positions" in message["updates"]
    ]
    assert set(np.round(moved, 6)) == {0.0, 0.2, 0.5}
    assert not [message for _, message in kept["messages"] if message["type"].startswith("Gui")]
    assert {message["type"] for _, message in kept["messages"]} >= {"SetCameraPositionMessage", "MeshMessage"}


@pytest.mark.parametrize("last", [snapshot(3, "1" * 16), snapshot(1)])
def test_a_run_that_begins_anew_ends_it(server: viser.ViserServer, last: Snapshot) -> None:
    assert recorded(server, HtmlRecording(server, 60.0), [snapshot(2), snapshot(4), last]) == [False, False, True]


def test_it_waits_for_a_run_and_writes_nothing_without_one(server: viser.ViserServer, tmp_path: Path) -> None:
    recording = HtmlRecording(server, 1.0)
    assert recorded(server, recording, [Snapshot(), replace(snapshot(2), entities=())]) == [False, False]
    with reserved_output(tmp_path / "run.html", overwrite=False) as file:
        assert recording.save(file) == 0
    assert not (tmp_path / "run.html").exists()
