"""XML Schema 1.0 for programs that read: unknown attributes and elements pass, as readers must let them.

Each document has a file of its own. In it the known elements are declared by their names, and every element allows any
child: those that are known must be valid, the others are skipped. So the schema does not see a known child that is
missing.
"""

from __future__ import annotations

from intellwheels_schemas.messages import Record
from intellwheels_schemas.shapes import Form, shape_of
from intellwheels_schemas.vectors import NAMES
from intellwheels_schemas.xsd import MADE, Types, classes_below, schema_file


def _elements(root: type[Record], types: Types) -> dict[str, str]:
    """Return the type of each element of a document by its name.

    Raises:
        TypeError: An element has two types in one document, which this form of schema cannot say.
    """
    found = {shape_of(root).root: root.__name__}
    for cls in classes_below([root]):
        for member in shape_of(cls).members:
            if member.form not in {Form.RECORD, Form.RECORDS, Form.ELEMENT}:
                continue
            name = member.record.__name__ if member.record is not None else ""
            if member.record is None and member.scalar is not None:
                name, _ = types.type_of(member.scalar)
            if found.setdefault(member.wire, name) != name:
                raise TypeError(f"{root.__name__}: <{member.wire}> is {found[member.wire]} and {name}")
    return found


def reader_files() -> dict[str, str]:
    """Return the schema of each document by file name."""
    files = {}
    for document, root in NAMES.items():
        types = Types(grows=True)
        complexes = "".join(types.complex(shape_of(cls)) for cls in classes_below([root]))
        elements = "".join(
            f'<xs:element name="{name}" type="{kind}"/>' for name, kind in _elements(root, types).items()
        )
        about = f"{document}, version iw.v1, to read: unknown attributes and elements pass. {MADE}"
        files[f"{document}.xsd"] = schema_file(types.simple_types() + complexes + elements, about)
    return files
