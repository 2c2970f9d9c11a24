"""The file with which a person or a program connects to the router of a lab: its name, password and certificate.

It is JSON with the certificates as PEM, so any language can read it. It is a secret: only its owner may read it.
"""

from __future__ import annotations

import base64
import datetime
import os
from collections.abc import MutableMapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Date, May, Name

ENDING: Final = ".iwid"
"""Ending of the names of these files."""
MAX_BYTES: Final = 65_536
"""Longest file."""
WARN_DAYS: Final = 7
"""Days before its end on which every command with an identity warns."""
_QUIET: Final = ",zenoh::api::session=info"
"""The more specific target counts, and of two equal ones the last."""


class IdentityFile(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", forbid_unknown_fields=True):
    """An identity.

    Attributes:
        identity: Version of the file.
        name: User name.
        password: Password, in plain text: the router must know it.
        connect: Endpoints of the router, for commands that are given none.
        may: What the lab's document allowed when the file was written, so that a denial can be put in words. The router
            decides, and says nothing.
        lab: Name of the lab; empty in an older file.
        until: Last day, in UTC, on which the identity or its certificate counts; None for no end.
        authority: Certificate of the lab's authority, which signs the router's; empty without `tls/` endpoints.
        certificate: Certificate of this identity; empty for a password alone.
        private_key: Private key of the certificate.
    """

    identity: Literal["iw.v1"] = "iw.v1"
    name: Name
    password: Annotated[str, Meta(min_length=8, max_length=200, pattern="^[!-9;-~]+$")]
    connect: tuple[str, ...] = ()
    may: tuple[May, ...] = ()
    lab: str = ""
    until: Date | None = None
    authority: str = ""
    certificate: str = ""
    private_key: str = ""

    def settings(self) -> dict[str, Any]:
        """Return the settings of Zenoh, by their paths, with which a session shows this identity."""
        found: dict[str, Any] = {"transport/auth/usrpwd": {"user": self.name, "password": self.password}}
        tls = {
            "root_ca_certificate": self.authority,
            "connect_certificate": self.certificate,
            "connect_private_key": self.private_key,
        }
        for name, pem in tls.items():
            if pem:
                # In memory, so that no second file holds the key.
                found[f"transport/link/tls/{name}_base64"] = base64.b64encode(pem.encode()).decode()
        if self.certificate:
            found["transport/link/tls/enable_mtls"] = True
        return found

    def days_left(self, today: datetime.date) -> int | None:
        """Return for how many days after today the identity counts: negative if it ended; None for no end."""
        return None if self.until is None else (datetime.date.fromisoformat(self.until) - today).days

    def __repr__(self) -> str:
        """Return the name without the password, so that no traceback shows it."""
        return f"IdentityFile(name={self.name!r})"


def read_identity(path: Path) -> IdentityFile:
    """Return the identity in a file.

    Raises:
        WireError: The file cannot be read, or is none; the text never shows what is in it.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise WireError("value", f"{path}: expected an identity file, got {error.strerror}", str(path)) from None
    try:
        return msgspec.json.decode(data[:MAX_BYTES], type=IdentityFile)
    except (msgspec.MsgspecError, UnicodeDecodeError):
        text = f"{path}: expected an identity file as iw-lab invite writes it, got something else"
        raise WireError("malformed", text, str(path)) from None


def check_identity(path: Path, today: datetime.date | None = None) -> str:
    """Check that an identity counts today, and return a warning in words; empty if there is nothing to warn of.

    Args:
        path: The identity file.
        today: The day in UTC; None for that of this machine's clock.

    Raises:
        WireError: The file is none, or it has expired.
    """
    own = read_identity(path)
    left = own.days_left(today or datetime.datetime.now(datetime.UTC).date())
    renewal = f"ask for another file, made with iw-lab renew {own.name}"
    if left is not None and left < 0:
        raise WireError("value", f"{path}: {own.name} expired after {own.until}; {renewal}", str(path))
    warnings = []
    if left is not None and left <= WARN_DAYS:
        warnings.append(f"{path}: {own.name} expires after {own.until}; {renewal}")
    if exposed := exposure(path):
        warnings.append(exposed)
    return "; ".join(warnings)


def exposure(path: Path) -> str:
    """Return in words that others on this machine can read or write a secret, and what to do; empty if they cannot."""
    if not path.exists() or not path.stat().st_mode & 0o077:
        return ""
    return f"{path}: others can read this secret; run chmod 600 {path}"


def keep_out_of_logs(environment: MutableMapping[str, str]) -> None:
    """Change the environment so that Zenoh's log, if `RUST_LOG` asks for it, has no password.

    From the level debug on, Zenoh logs the whole configuration of a session when it opens it (seen with 1.10.2).

    Args:
        environment: `os.environ`, before the log begins.
    """
    asked = environment.get("RUST_LOG", "")
    if asked and not asked.endswith(_QUIET):
        environment["RUST_LOG"] = f"{asked}{_QUIET}"


def write_secret(path: Path, data: bytes) -> None:
    """Write a file that only its owner may read, in place of an older one.

    Raises:
        OSError: The folder cannot be written.
    """
    part = path.with_name(f"{path.name}.part")
    part.unlink(missing_ok=True)
    with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(data)
    part.replace(path)


def identity_text(identity: IdentityFile) -> bytes:
    """Return the bytes of an identity file."""
    return msgspec.json.format(msgspec.json.encode(identity), indent=2) + b"\n"
