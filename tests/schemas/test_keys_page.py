from __future__ import annotations

import functools
import re
from pathlib import Path

from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.file_records import InputHeader, Inputs, InputTick, Join, TraceBody, TraceHeader, TraceTick
from intellwheels_schemas.keys_page import keys_page
from intellwheels_schemas.messages import ERROR_CODES, EVENT_CODES, REFUSED_CODES, RESULT_CODES
from intellwheels_schemas.shapes import shape_of
from intellwheels_schemas.vectors import NAMES

SCHEMAS = Path(__file__).parents[2] / "schemas"


@functools.cache
def page() -> str:
    """The page; made only in a worker that tests it."""
    return keys_page()


def test_every_key_field_and_code_stands_there() -> None:
    for channel in CHANNELS.values():
        assert f"| `{channel.key}` |" in page()
    for name, cls in NAMES.items():
        section = page().partition(f"### {name}\n")[2].partition("\n### ")[0]
        for member in shape_of(cls).members:
            assert f"| `{member.wire}` |" in section, (name, member.wire)
    for record in (InputHeader, InputTick, Inputs, Join, TraceHeader, TraceTick, TraceBody):
        section = page().partition(f"### {record.__name__}\n")[2].partition("\n### ")[0]
        for wire in record.__struct_encode_fields__:
            assert f"| `{wire}` |" in section, (record, wire)
    for code in (*ERROR_CODES, *EVENT_CODES, *REFUSED_CODES, *RESULT_CODES):
        assert f"| `{code}` |" in page()


def test_links_lead_somewhere() -> None:
    headings = {line.lstrip("# ").lower() for line in page().splitlines() if line.startswith("#")}
    for target in re.findall(r"\]\(([^)]+)\)", page()):
        if target.startswith("#"):
            assert target[1:] in headings
        else:
            assert (SCHEMAS / target).exists()


def test_what_a_query_takes_behind_its_key_stands_there() -> None:
    for words in ("`join` takes `?session=S`", "`event` takes `?since=N`"):
        assert words in page()


def test_limits_of_the_contract_stand_there() -> None:
    for line in ("| bytes of Robot | 65,536 |", "| bytes of Pose | 16,384 |", "| sensors of a robot | 64 |"):
        assert line in page()
