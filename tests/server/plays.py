"""A run with a bit of everything, its log, and a stage on which that log is played."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from intellwheels_schemas.messages import Leave, Reset, Restore, Result
from intellwheels_server.log.reported_poses import ReportedPoses
from intellwheels_server.log.seekable_log import SeekableLog
from intellwheels_server.service.log_playback import Playback
from intellwheels_server.service.service_state import Options
from tests.server.stage import Stage


class Seen(NamedTuple):
    """What a live run's clock said of a tick."""

    run: str
    tick: int
    hash: str


def record(path: Path, ticks: int = 50) -> list[Seen]:
    """Write the log of three runs of one world; return what was seen of each tick, in order.

    Run 1: chair1 from the start, chair2 joins at tick 10 and leaves at 30, a save at 20. Run 2: a reset, chair1 alone.
    Run 3: the save restored, with chair2 still to come.
    """
    stage = Stage(pace="realtime", log=path)
    seen: list[Seen] = []

    def go(count: int) -> None:
        for _ in range(count):
            for name in stage.sessions:
                stage.act(name, 0.5, 0.6)
            tick = stage.tick
            while stage.tick == tick:
                stage.work(0.01)
            note_state()

    def note_state() -> None:
        seen.append(Seen(stage.live_run.state.run, stage.tick, stage.live_run.digest()))

    stage.join("chair1")
    note_state()
    go(10)
    stage.join("chair2", instance="b" * 16)
    go(10)
    stage.result("save")
    go(10)
    stage.ask("leave", "chair2", Leave(session=stage.sessions.pop("chair2")))
    go(ticks - 30)
    assert isinstance(stage.result("reset", Reset(seed="9")), Result)
    note_state()
    go(15)
    stage.result("restore", Restore(slot="s1"))
    note_state()
    go(15)
    stage.live_run.finish(stage.now)
    assert stage.log is not None
    stage.log.close()
    return seen


class PlayStage(Stage):
    """A player, its clock, and all that came out."""

    def __init__(
        self,
        path: Path,
        *,
        speed: float = 1.0,
        quit_at_end: bool = False,
        reported: Path | None = None,
        waits: bool = False,
    ) -> None:
        self.now = 100.0
        self.sent = []
        self.lines = []
        self.notes = []
        self.sessions = {}
        self.keys = {}
        self.log = None
        self.recording = SeekableLog(path)
        options = Options(
            world="main-play", setup=self.recording.header.world_setup(), speed=speed, quit_at_end=quit_at_end
        )
        self.beside = None if reported is None else SeekableLog(reported)
        told = None if self.beside is None else ReportedPoses(self.recording.runs, self.beside)
        self.live_run = Playback(options, self, lambda: 1.8e9 + self.now, self.recording, told)  # type: ignore[assignment]
        self.live_run.begin()
        if not waits:
            self.live_run._service.pacing.paused = False
        self.work()

    def close(self) -> None:
        self.recording.close()
        if self.beside is not None:
            self.beside.close()
