"""The files beside the document of a lab: passwords, and the certificates of its authority and its router."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import read_with_lines
from intellwheels_schemas.messages import Lab


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

    def _beside(self, ending: str) -> Path:
        return self.lab.with_suffix(f".{ending}").absolute()


def read_lab(path: Path) -> Lab:
    """Return the document of a lab.

    Raises:
        WireError: It is missing or wrong; the text has file and line.
    """
    return read_with_lines(Lab, path)[0]


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
