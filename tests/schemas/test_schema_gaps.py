from __future__ import annotations

import json

from intellwheels_schemas.schema_gaps import GAPS
from tests.schemas.documents import REFUSED, SCHEMAS, is_parsed_and_valid


def test_schemas_refuse_every_refused_document_except_those_that_are_listed() -> None:
    listed = [entry["File"] for entry in json.loads((REFUSED / "index.json").read_bytes())]
    accepted = {name for name in listed if is_parsed_and_valid(REFUSED / name)}
    assert accepted == {name for gap in GAPS for name in gap.vectors}
    assert len(listed) >= 150
    assert len(accepted) <= 20


def test_page_lists_each_gap_with_its_reason() -> None:
    page = (SCHEMAS / "KEYS.md").read_text(encoding="utf-8")
    for gap in GAPS:
        assert f"| {gap.what} | {gap.language} | {gap.why} |" in page
