"""The rules of XML documents that XML Schema 1.0 cannot express, as ISO Schematron with XPath 1.0.

A document is checked with an XML Schema first. The rules do not mind unknown fields, so they are for readers and
writers.
"""

from __future__ import annotations

from xml.sax.saxutils import escape, quoteattr

from intellwheels_schemas.field_rules import assertions
from intellwheels_schemas.messages import ROOTS, OperatorSay, Record
from intellwheels_schemas.shapes import shape_of
from intellwheels_schemas.xsd import MADE, classes_below


def _contexts() -> dict[str, type[Record]]:
    """Return the class of each element by a pattern that finds it: its own name and that of its parent."""
    roots = [cls for cls in ROOTS if cls is not OperatorSay]
    found: dict[str, type[Record]] = {f"/{ROOTS[cls]}": cls for cls in roots}
    # Dictionaries keep their order; a set of classes has another one in each process.
    parents = {wire.removeprefix("/"): {cls: None} for wire, cls in found.items()}
    for cls in classes_below(list(roots)):
        for member in shape_of(cls).members:
            if member.record is not None:
                parents.setdefault(member.wire, {})[member.record] = None
    for parent, classes in parents.items():
        for cls in classes:
            for member in shape_of(cls).members:
                if member.record is not None:
                    found[f"{parent}/{member.wire}"] = member.record
    return found


def schematron() -> str:
    """Return the text of `rules.sch`."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f"<!-- {MADE} -->",
        '<schema xmlns="http://purl.oclc.org/dsdl/schematron" queryBinding="xslt">',
        "  <title>What XML Schema cannot say of the documents of version iw.v1.</title>",
    ]
    for rule in assertions(_contexts()):
        context, test, text = quoteattr(rule.context), f'"{rule.test}"', escape(rule.text)
        lines.append(f"  <pattern><rule context={context}><assert test={test}>{text}</assert></rule></pattern>")
    return "\n".join([*lines, "</schema>"]) + "\n"
