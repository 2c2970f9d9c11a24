"""The description of a field: the string below it in its class, or else the sentence of its type.

It is read from the source of the class, and only when pages and schemas are generated. No process of an agent or a
simulator needs it.
"""

from __future__ import annotations

import ast
import inspect
import sys
from functools import cache
from types import ModuleType
from typing import Any

import msgspec

Struct = type[msgspec.Struct]


@cache
def _strings(module: ModuleType) -> dict[str, dict[str, str]]:
    """Return the strings below the fields of a module's classes, by class and Python name."""
    found: dict[str, dict[str, str]] = {}
    for node in ast.parse(inspect.getsource(module)).body:
        if not isinstance(node, ast.ClassDef):
            continue
        fields = found[node.name] = {}
        for statement, below in zip(node.body, node.body[1:], strict=False):
            if (
                isinstance(statement, ast.AnnAssign)
                and isinstance(statement.target, ast.Name)
                and isinstance(below, ast.Expr)
                and isinstance(below.value, ast.Constant)
                and isinstance(below.value.value, str)
            ):
                fields[statement.target.id] = " ".join(below.value.value.split())
    return found


def is_sentence(text: str) -> bool:
    """Return whether a text is a sentence and not the label of a type."""
    return text[:1].isupper() and text.endswith(".")


def _of_type(kind: Any) -> str:
    """Return the outermost sentence of a type, or an empty string."""
    while True:
        if isinstance(kind, msgspec.inspect.Metadata):
            text = str((kind.extra_json_schema or {}).get("description", ""))
            if is_sentence(text):
                return text
            kind = kind.type
        elif isinstance(kind, msgspec.inspect.UnionType):
            others = [one for one in kind.types if not isinstance(one, msgspec.inspect.NoneType)]
            if len(others) != 1:
                return ""
            kind = others[0]
        else:
            return ""


@cache
def field_docs(cls: Struct) -> dict[str, str]:
    """Return the description of each field of a class by its Python name; empty if there is none."""
    info = msgspec.inspect.type_info(cls)
    if not isinstance(info, msgspec.inspect.StructType):
        raise TypeError(f"expected a struct, got {cls}")
    docs: dict[str, str] = {}
    for field in info.fields:
        owners = (_strings(sys.modules[owner.__module__]).get(owner.__name__, {}) for owner in cls.__mro__[:-1]
                  if owner.__module__.startswith("intellwheels"))  # fmt: skip
        own = next((strings[field.name] for strings in owners if field.name in strings), "")
        docs[field.name] = own or _of_type(field.type)
    return docs
