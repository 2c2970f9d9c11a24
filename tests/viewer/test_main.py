"""The command: what it takes, what it says, how it ends."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from intellwheels_experiments.run.endpoints import free_port
from intellwheels_viewer import __main__ as viewer_main
from intellwheels_viewer import viewer_service
from intellwheels_viewer.__main__ import main, parser
from tests.e2e.stage import Stage, run

pytestmark = pytest.mark.process


def test_the_defaults_are_this_machine_only() -> None:
    given = parser().parse_args([])
    assert (given.host, given.port, given.dark, given.allow_host) == ("127.0.0.1", None, False, [])
    assert given.world is None  # the only one there is


def test_length_of_a_recording_needs_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--seconds", "5"])
    assert ended.value.code == 2
    assert "--seconds: expected with --record, got none" in capsys.readouterr().err


def test_options_may_be_repeated_where_that_makes_sense() -> None:
    given = parser().parse_args(["--allow-host", "a", "--allow-host", "b", "--port", "0", "--world", "lab"])
    assert given.allow_host == ["a", "b"]
    assert (given.port, given.world) == (0, "lab")


@pytest.mark.parametrize("port", ["-1", "65536", "x", "1.5", "", "²"])
def test_what_is_no_port_is_wrong_usage(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        parser().parse_args([f"--port={port}"])
    assert ended.value.code == 2
    assert "--port: expected a port in [0, 65535], got" in capsys.readouterr().err


def test_a_world_that_is_no_name_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--world", "No Name"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("iw-viewer: --world: expected")
    assert "Traceback" not in err


def test_a_recording_that_cannot_be_written_is_refused_before_anything_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--record", str(tmp_path / "none" / "run.html")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"iw-viewer: --record: expected a folder that exists, got {tmp_path / 'none'}")
    assert list(tmp_path.iterdir()) == []


def test_a_recording_replaces_a_file_only_if_that_is_wanted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.html").write_text("old")
    assert main(["--record", str(tmp_path / "run.html")]) == 2
    assert "run.html: the file exists; --overwrite replaces it" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["--overwrite"])
    assert "--overwrite: expected with --record, got none" in capsys.readouterr().err


def test_help_comes_without_what_takes_long_to_import() -> None:
    code = (
        "import sys\nfrom intellwheels_viewer.__main__ import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "print(sorted({'viser', 'numpy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert "--allow-host" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_it_says_where_the_page_is_and_ends_when_told(tmp_path: Path) -> None:
    with Stage(tmp_path, "viewer-main") as stage:
        stage.start("viewer", "intellwheels_viewer", "--port", "0", "--connect", stage.endpoint)
        url = stage.line("viewer", "ready")["url"]
        assert url.startswith("http://127.0.0.1:")
        stage.signal("viewer", signal.SIGTERM)
        assert stage.exit("viewer") == 0
        assert "Traceback" not in stage.log("viewer")


def test_a_port_that_is_taken_ends_it_in_words() -> None:
    import socket

    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        done = run("intellwheels_viewer", "--port", str(holder.getsockname()[1]))
    assert done.returncode == 1
    assert "the port is in use" in done.stderr
    assert "--port" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_endpoint_that_is_none_ends_it_in_words() -> None:
    done = run("intellwheels_viewer", "--port", str(free_port()), "--connect", "nonsense")
    assert done.returncode == 2
    assert "iw-viewer: --connect: expected an endpoint such as" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(("words", "port"), [([], 8080), (["--port", "8123"], 8123), (["--record"], 0)])
def test_a_recording_takes_a_free_port_unless_one_is_given(
    words: list[str], port: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    ports: list[int] = []

    def serve(options: viewer_service.Options, *_: object) -> int:
        ports.append(options.port)
        return 0

    monkeypatch.setattr(viewer_service, "serve", serve)
    monkeypatch.setattr(viewer_main, "stop_on_signals", lambda _: threading.Event())
    assert main([*words, str(tmp_path / "run.html")] if words == ["--record"] else words) == 0
    assert ports == [port]
