"""What the schemas accept although the simulator refuses it, with the reason. KEYS.md lists it, and a test compares."""

from __future__ import annotations

from typing import Final, NamedTuple


class Gap(NamedTuple):
    """A kind of wrong document that a schema language cannot refuse.

    Attributes:
        what: What is wrong in the document.
        language: The language of the schema.
        why: Why the language cannot express it.
        vectors: Refused vectors of this kind.
    """

    what: str
    language: str
    why: str
    vectors: tuple[str, ...]


_JSON: Final = "JSON Schema"
_XML: Final = "XML Schema and Schematron"
_PARSED: Final = "A schema sees the document only after parsing."
_COMPARED: Final = "JSON Schema compares no value with another one."

GAPS: Final = (
    Gap("a name twice in an object", _JSON, _PARSED,
        ("Actions-twice.json", "Actions-twice-escaped.json", "Actions-goal-twice.json")),
    Gap("`NaN`, which some parsers read", _JSON, _PARSED, ("Actions-nan.json",)),
    Gap("`5.0` or `1e3` for a whole number", _JSON, "To JSON Schema they are whole numbers.",
        ("Actions-tick-float.json", "Actions-tick-exponent.json")),
    Gap("an id twice in a robot, an agent twice in a crew", _JSON, _COMPARED,
        ("Robot-id-twice.json", "CrewActions-twice.json")),
    Gap("more than 64 sensors of several kinds together", _JSON, "JSON Schema adds no numbers.",
        ("Robot-sensors.json",)),
    Gap("`MinRange` of at least `MaxRange`, `Bottom` of at least `Top`, `Part` of at least `Parts`", _JSON, _COMPARED,
        ("Robot-ranges.json", "Robot-part-flat.json", "CrewActions-part.json")),
    Gap("a range where its `Status` is not ok, if not all are alike", _JSON,
        "JSON Schema does not pair the items of two lists.", ("Measures-lidar-value-none.json",)),
    Gap("the agents and rows of a scene", _JSON, _COMPARED, ()),
    Gap("an unknown word in the braces of a `Command`", _XML, "A command may have other braces, as of JSON text.",
        ("Scene-command-placeholder.xml",)),
    Gap("a document type", _XML, _PARSED, ("Actions-document-type.xml", "Actions-entities.xml")),
    Gap("too many bytes", f"{_JSON}, {_XML}", _PARSED, ("UserInput-long.xml",)),
    Gap("a range where its `Status` is not ok", _XML, "XPath 1.0 does not pair the items of two lists.",
        ("Measures-lidar-value-none.xml",)),
    Gap("a negative variance in `Covariance`", _XML, "Schematron does not see the items of a list.",
        ("Pose-covariance-negative.xml",)),
    Gap("a row of several factors that does not exist", _XML, "XPath 1.0 does not combine levels.",
        ("Scene-two-factors-no-row.xml",)),
    Gap("a number with an exponent that breaks a rule between two numbers", _XML, "XPath 1.0 reads no exponents.", ()),
    Gap("a required child element that is missing", "XML Schema for readers",
        "XML Schema 1.0 cannot require an element beside unknown ones.", ()),
)  # fmt: skip
"""All of them."""
