"""The command `iw-server`: runs a simulated world on the network, or an input log again."""

from __future__ import annotations

import argparse
import io
import os
import sys
from pathlib import Path

from intellwheels_schemas import defaults
from intellwheels_schemas.endpoint_form import check_free
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.input_reader import cut_text, unchained_text
from intellwheels_schemas.link import link_of
from intellwheels_schemas.names import check_name
from intellwheels_schemas.output_paths import check_output_file, check_output_folder, open_output
from intellwheels_schemas.panic_watch import PanicWatch
from intellwheels_schemas.process import stop_on_signals
from intellwheels_server.quick_start import QuickStart
from intellwheels_server.server_options import PLAY_SUFFIX, options_of, parser

_ALWAYS = ("lifeline", "link_listens")
WITH_LOG = {
    "resimulate": ("prove", "trace", "overwrite", *_ALWAYS),
    "play": ("reported", "speed", "quit_at_end", "world", "connect", "listen", "config", "identity", *_ALWAYS),
}
"""Options that a log which is run again or played back leaves open. All others are those of a live run."""
PLAY_NAME_LENGTH = 32 - len(PLAY_SUFFIX)
"""Characters of that name that are kept. A name has at most 32."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code."""
    grammar = parser()
    given = grammar.parse_args(arguments)
    lacking = missing_extra("server")
    if lacking is not None:
        print(f"iw-server: {lacking}", file=sys.stderr)
        return 2
    start = QuickStart()
    try:
        return _perform(grammar, given, start)
    finally:
        start.end()


def _end_on_panic() -> None:
    """End this process when Zenoh panics, so that whoever started it can start another one."""

    def end(line: str) -> None:
        watch.close()
        print(f"iw-server: ended why={line!r}; start it again", file=sys.stderr, flush=True)
        # The session cannot be closed any more. A log loses at most its last second, as with any sudden end.
        os._exit(1)

    watch = PanicWatch(end)


def _perform(grammar: argparse.ArgumentParser, given: argparse.Namespace, start: QuickStart) -> int:
    # Imported late, as everything of the world is: numba and zenoh are slow to load, `--help` does not need them, and
    # without the extra they are not there.
    from intellwheels_server.log.input_log import LogError  # noqa: PLC0415

    if given.trace is not None and given.resimulate is None:
        grammar.error("--trace: expected with --resimulate, got none")
    if given.prove and (given.resimulate is None or given.trace is not None):
        grammar.error("--prove: expected with --resimulate and without --trace")
    if given.reported is not None and given.play is None:
        grammar.error("--reported: expected with --play, got none")
    if given.overwrite and given.log is None and given.trace is None:
        grammar.error("--overwrite: expected with --log or --trace, got none")
    if given.at and given.branch is None:
        grammar.error("--at: expected with --branch, got none")
    for reads, left in WITH_LOG.items():
        if getattr(given, reads) is not None:
            _refuse_live_options(grammar, given, reads, left)
    try:
        _check_outputs(given)
    except WireError as error:
        print(f"iw-server: {error.text}", file=sys.stderr)
        return 2
    if given.resimulate is not None:
        start.end()  # it works from here on
        if given.trace is not None:
            return _trace(given.resimulate, given.trace)
        return _resimulate(given.resimulate, prove=given.prove)
    if given.play is not None:
        return _play(given, start)
    given.world = defaults.WORLD if given.world is None else given.world
    try:
        options, route = options_of(given)
    except WireError as error:
        print(f"iw-server: {error.text}", file=sys.stderr)
        return 2
    except (LogError, OSError) as error:
        print(f"iw-server: --branch: {error}", file=sys.stderr)
        return 2
    except ValueError as error:
        grammar.error(str(error))
    try:
        check_free(route.listen)
    except ConnectionError as error:
        print(f"iw-server: {error}", file=sys.stderr)
        return 1
    stop = stop_on_signals(given.lifeline)
    _end_on_panic()
    from intellwheels_server.service.claim_watch import WorldTakenError  # noqa: PLC0415
    from intellwheels_server.service.simulator_peer import serve  # noqa: PLC0415
    from intellwheels_server.world.warmup import warm  # noqa: PLC0415

    warm()
    start.end(freeze=True)
    try:
        return serve(options, route, stop, given.log, runs=given.runs)
    except (ConnectionError, WorldTakenError) as error:
        print(f"iw-server: {error}", file=sys.stderr)
    except OSError as error:
        where = "" if error.filename is None else f"{written_by(given, error)}: "
        print(f"iw-server: {where}{error.strerror or error}", file=sys.stderr)
    return 1


def _refuse_live_options(
    grammar: argparse.ArgumentParser, given: argparse.Namespace, reads: str, left: tuple[str, ...]
) -> None:
    """End the command if an option is given that the log of `--resimulate` or `--play` makes meaningless."""
    for name, value in vars(given).items():
        if name not in (reads, *left) and value != grammar.get_default(name):
            grammar.error(f"--{name.replace('_', '-')}: expected a live run, got --{reads}, whose log decides it")


def written_by(given: argparse.Namespace, error: OSError) -> str:
    """Return the option and the file that could not be written."""
    file = Path(error.filename or given.log or given.runs or "")
    return f"{'--log' if given.runs is None or file == given.log else '--runs'} {file}"


def _check_outputs(given: argparse.Namespace) -> None:
    """Check what will be written.

    Raises:
        WireError: It cannot be written, or it would replace what is read.
    """
    read = given.resimulate or given.branch
    for written, option in ((given.log, "--log"), (given.trace, "--trace")):
        if read is not None and read.exists() and written is not None and written.exists() and written.samefile(read):
            text = f"{option}: expected another file than the log that is read, got {written}"
            raise WireError("value", text, option)
    check_output_file(given.log, "--log", overwrite=given.overwrite)
    check_output_file(given.trace, "--trace", overwrite=given.overwrite)
    check_output_folder(given.runs, "--runs")


def _play(given: argparse.Namespace, start: QuickStart) -> int:
    from intellwheels_server.log.input_log import LogError, read_header  # noqa: PLC0415
    from intellwheels_server.service.service_state import Options  # noqa: PLC0415

    try:
        with given.play.open("rb") as file:
            world = read_header(file, str(given.play)).world
        if given.reported is not None:
            with given.reported.open("rb") as file:
                read_header(file, str(given.reported))
        if given.world is None:
            given.world = f"{world[:PLAY_NAME_LENGTH]}{PLAY_SUFFIX}"
        check_name(given.world, "--world")
        route = link_of(given)
        check_free(route.listen)
    except ConnectionError as error:
        print(f"iw-server: {error}", file=sys.stderr)
        return 1
    except (WireError, LogError) as error:
        print(f"iw-server: {error.text if isinstance(error, WireError) else error}", file=sys.stderr)
        return 2 if isinstance(error, WireError) else 1
    except OSError as error:
        print(f"iw-server: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    stop = stop_on_signals(given.lifeline)
    _end_on_panic()
    from intellwheels_server.log.seekable_log import SeekableLog  # noqa: PLC0415
    from intellwheels_server.service.claim_watch import WorldTakenError  # noqa: PLC0415
    from intellwheels_server.service.simulator_peer import serve  # noqa: PLC0415
    from intellwheels_server.world.warmup import warm  # noqa: PLC0415

    def progress(lines: int) -> None:
        print(f"reading lines={lines}", file=sys.stderr, flush=True)
        if stop.is_set():
            raise SystemExit(0)

    def read(log: Path) -> SeekableLog:
        recording = SeekableLog(log, progress)
        if not recording.chained:
            print(unchained_text(str(log)), file=sys.stderr)
        if recording.cut:
            print(cut_text(str(log), recording.last_tick), file=sys.stderr)
        if recording.differs is not None:
            print(f"{log}: this playback differs from the recorded run: {recording.differs}", file=sys.stderr)
        return recording

    warm()
    start.end(freeze=True)
    try:
        recording = read(given.play)
        reported = None if given.reported is None else read(given.reported)
        setup = recording.header.world_setup()
        options = Options(world=given.world, setup=setup, speed=given.speed, quit_at_end=given.quit_at_end)
        return serve(options, route, stop, recording=recording, reported=reported)
    except (ConnectionError, WorldTakenError, LogError) as error:
        print(f"iw-server: {error}", file=sys.stderr)
    return 1


def _resimulate(path: Path, *, prove: bool) -> int:
    from intellwheels_server.log.input_log import LogError  # noqa: PLC0415
    from intellwheels_server.log.proof import proof_line  # noqa: PLC0415
    from intellwheels_server.log.resimulate import resimulate  # noqa: PLC0415

    try:
        found = resimulate(path, lambda ticks: print(f"resimulating ticks={ticks}", file=sys.stderr, flush=True))
    except LogError as error:
        print(f"iw-server: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"iw-server: --resimulate {path}: {error.strerror}", file=sys.stderr)
        return 1
    if found.differs is not None:
        print(f"differs {found.differs}", flush=True)
        return 1
    if not found.chain:
        print(unchained_text(str(path)), file=sys.stderr)
    if found.cut:
        print(cut_text(str(path), found.tick), file=sys.stderr)
    if prove and found.chain and not found.cut:
        print(proof_line(found), flush=True)
        return 0
    if prove:
        print("iw-server: --prove: expected a whole log with checksums; nothing is proved", file=sys.stderr)
    word = "truncated" if found.cut else "same"
    print(f"{word} ticks={found.ticks} tick={found.tick} hash={found.hash}", flush=True)
    return 1 if prove or found.cut else 0


def _trace(log: Path, target: Path) -> int:
    from intellwheels_server.log.input_log import LogError  # noqa: PLC0415
    from intellwheels_server.log.true_trace import trace_lines  # noqa: PLC0415

    try:
        with io.BufferedWriter(open_output(target)) as file:
            file.writelines(trace_lines(log, lambda text: print(text, file=sys.stderr)))
    except LogError as error:
        print(f"iw-server: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"iw-server: {error.filename or target}: {error.strerror}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
