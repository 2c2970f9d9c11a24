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


def test_generated_files_are_current() -> None:
    """If this fails: python -m intellwheels_schemas."""
    assert generate.stale(SCHEMAS) == []


def test_released_fields_do_not_change() -> None:
    """If this fails, old peers break: add an optional field instead, or begin another version."""
    assert generate.broken_promises(released()) == []


def test_what_breaks_a_promise_is_told() -> None:
    before = copy.deepcopy(released())
    before["Actions"]["Speed"] = before["Actions"]["LeftMotor"]
    before["Pose"]["X"]["Unit"] = "mm"
    del before["Joined"]["Session"]
    del before["Actions"]["Say"]
    before["Gone"] = {"X": before["Pose"]["Y"]}
    assert [text.partition(":")[0] for text in generate.broken_promises(before)] == [
        "Actions.Speed",
        "Pose.X",
        "Gone.X",
        "Joined.Session",
    ]


def test_writing_makes_what_is_stale_and_takes_out_what_is_not_generated(tmp_path: Path) -> None:
    generate.write(tmp_path)
    assert generate.stale(tmp_path) == []
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
