"""The files beside the document of a lab: passwords, and the certificates of its authority and its router."""

from __future__ import annotations

import datetime
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import read_with_lines
from intellwheels_schemas.identity_file import exposure
from intellwheels_schemas.messages import Lab

_NO_VERBS: Final = re.compile(r"""\bVerbs\s*=\s*(?:"\s*"|'\s*')""")
"""Whoever writes it means none, but without verbs an operator has all."""


@dataclass(frozen=True)
class LabFiles:
    """The paths of a lab: `room3.users` and others beside `room3.xml`."""

    lab: Path

    @property
    def users(self) -> Path:
        """Passwords, which the router reads when it starts."""
        return self._beside("users")

    @property
    def authority(self) -> Path:
        """Certificate of the authority. Everybody may have it."""
        return self._beside("ca.pem")

    @property
    def authority_key(self) -> Path:
        """Key of the authority: whoever has it can be anybody."""
        return self._beside("ca.key")

    @property
    def router(self) -> Path:
        """Certificate of the router."""
        return self._beside("router.pem")

    @property
    def router_key(self) -> Path:
        """Key of the router."""
        return self._beside("router.key")

    def exposed(self) -> list[str]:
        """Return in words which secrets others on this machine can read, and what to do."""
        return [words for secret in (self.users, self.authority_key, self.router_key) if (words := exposure(secret))]

    def _beside(self, ending: str) -> Path:
        return self.lab.with_suffix(f".{ending}").absolute()


def read_lab(path: Path) -> Lab:
    """Return the document of a lab.

    Raises:
        WireError: It is missing or wrong, or an operator has an empty list of verbs; the text has file and line.
    """
    lab = read_with_lines(Lab, path)[0]
    text = path.read_text(encoding="utf-8", errors="replace")
    if (empty := _NO_VERBS.search(text)) is not None:
        where = f"{path}:{text.count(chr(10), 0, empty.start()) + 1}"
        raise WireError(
            "value", f"{where}: Verbs: expected verbs, or no Verbs for all of them, got an empty list", where
        )
    return lab


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


def router_until(files: LabFiles) -> datetime.date | None:
    """Return the last day of the router's certificate; None without one.

    Raises:
        WireError: The file is none.
    """
    if not files.router.exists():
        return None
    try:
        word, _, text = files.router.read_text(encoding="ascii").partition("\n")[0].partition(": ")
        return datetime.date.fromisoformat(text if word == "Until" else "")
    except (ValueError, OSError):
        where = str(files.router)
        raise WireError("value", f"{where}: expected the certificate that iw-lab keys makes", where) from None
