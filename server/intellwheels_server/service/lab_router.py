"""The configuration of a lab's router: who may connect, and what each identity may do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from intellwheels_schemas.access_rules import Rule, rules_for
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import read_with_lines
from intellwheels_schemas.messages import Lab
from intellwheels_schemas.rights import rights_key


def read_lab(path: Path) -> Lab:
    """Return the document of a lab.

    Raises:
        WireError: It is missing or wrong; the text has file and line.
    """
    return read_with_lines(Lab, path)[0]


def users_file(lab: Path) -> Path:
    """Return the file with the passwords of a lab: beside its document, `room3.users` for `room3.xml`."""
    return lab.with_suffix(".users").absolute()


def read_users(path: Path) -> dict[str, str]:
    """Return the passwords by user name.

    Raises:
        WireError: The file is missing or is none; the text never shows what is in it.
    """
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "other bytes"
        raise WireError("value", f"{path}: expected the users that iw-lab keys writes, got {why}", str(path)) from None
    users: dict[str, str] = {}
    for number, line in enumerate(lines, 1):
        name, colon, password = line.partition(":")
        if not colon or not name or not password:
            where = f"{path}:{number}"
            raise WireError("malformed", f"{where}: expected name:password, got another line", where)
        users[name] = password
    return users


def lab_settings(lab: Lab, users: Path) -> dict[str, Any]:
    """Return the settings of a router that allows what a lab lists and denies everything else.

    Args:
        lab: The document.
        users: The file with the passwords; the settings name it and do not contain it.
    """
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    for identity in lab.identity:
        rights = (rights_key(identity.name),)
        own = [Rule(("query",), "ingress", rights), Rule(("reply",), "egress", rights)]
        own += [rule for may in identity.may for rule in rules_for(may)]
        names = [f"{identity.name}/{number}" for number in range(len(own))]
        for name, rule in zip(names, own, strict=True):
            rules.append({
                "id": name, "permission": "allow", "flows": [rule.flow], "messages": list(rule.messages),
                "key_exprs": list(rule.keys),
            })  # fmt: skip
        policies.append({"rules": names, "subjects": [identity.name]})
    return {
        "access_control": {
            "enabled": True,
            "default_permission": "deny",
            "rules": rules,
            "subjects": [{"id": identity.name, "usernames": [identity.name]} for identity in lab.identity],
            "policies": policies,
        },
        "transport/auth/usrpwd": {"dictionary_file": str(users)},
        "adminspace/enabled": False,
    }
