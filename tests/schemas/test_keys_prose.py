from __future__ import annotations

from pathlib import Path

from intellwheels_schemas import keys_prose

PAGE = (Path(__file__).parents[2] / "schemas" / "KEYS.md").read_text(encoding="utf-8")


def test_page_has_the_prose_and_no_gap_that_was_not_filled() -> None:
    for text in (keys_prose.HEAD, keys_prose.NOTES, keys_prose.SCHEMAS, keys_prose.LOGS):
        assert text.strip().splitlines()[0] in PAGE
    for gap in ("{name}", "{reserved}", "{refused}", "{accepted}", "{overseers}", "<late>", "{scan_"):
        assert gap not in PAGE
