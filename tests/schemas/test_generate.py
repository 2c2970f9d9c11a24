from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

from intellwheels_schemas import generate

SCHEMAS = Path(__file__).parents[2] / "schemas"


def released() -> dict[str, dict[str, dict[str, Any]]]:
    found: dict[str, dict[str, dict[str, Any]]] = json.loads((SCHEMAS / generate.RELEASED).read_bytes())
    return found


def broken_promises(released: dict[str, dict[str, dict[str, Any]]]) -> list[str]:
    """Return in words what a peer of the released version could no longer rely on.

    Classes and optional fields may be added; nothing that was released may be removed or changed.
    """
    now = generate.fields()
    broken = []
    for name, members in released.items():
        for wire, signature in members.items():
            place = f"{name}.{wire}"
            if name not in now or wire not in now[name]:
                broken.append(f"{place}: expected to stay, it was removed")
            elif now[name][wire] != signature:
                broken.append(f"{place}: expected {signature}, got {now[name][wire]}")
    for name, members in now.items():
        for wire, signature in members.items():
            if name in released and wire not in released[name] and signature["Required"]:
                broken.append(f"{name}.{wire}: expected new fields to be optional, it is required")
    return broken


def test_generated_files_are_current() -> None:
    """If this fails: python -m intellwheels_schemas."""
    assert generate.stale(SCHEMAS) == []


def test_released_fields_do_not_change() -> None:
    """If this fails, old peers break: add an optional field instead, or begin another version."""
    assert broken_promises(released()) == []


def test_what_breaks_a_promise_is_told() -> None:
    before = copy.deepcopy(released())
    before["Actions"]["Speed"] = before["Actions"]["LeftMotor"]
    before["Pose"]["X"]["Unit"] = "mm"
    del before["Joined"]["Session"]
    del before["Actions"]["Say"]
    before["Gone"] = {"X": before["Pose"]["Y"]}
    assert [text.partition(":")[0] for text in broken_promises(before)] == [
        "Actions.Speed",
        "Pose.X",
        "Gone.X",
        "Joined.Session",
    ]


def test_writing_makes_what_is_stale_and_takes_out_what_is_not_generated(tmp_path: Path) -> None:
    generate.write(tmp_path)
    (tmp_path / "vectors" / "Old.json").write_text("{}", encoding="utf-8")
    (tmp_path / "KEYS.md").unlink()
    assert generate.write(tmp_path) == ["KEYS.md", "vectors/Old.json"]
    assert generate.write(tmp_path) == []
    assert not (tmp_path / "vectors" / "Old.json").exists()


def test_refused_documents_are_listed_with_class_code_and_place() -> None:
    index = json.loads((SCHEMAS / "vectors" / "refused" / "index.json").read_bytes())
    assert len(index) >= 50
    for line in index:
        assert (SCHEMAS / "vectors" / "refused" / line["File"]).is_file()
        assert line.keys() == {"File", "Class", "Code", "Place", "Text"}
