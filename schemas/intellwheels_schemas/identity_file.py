"""The file with which a person or a program connects to the router of a lab: its name and its password, as JSON.

Any language can read it. It is a secret: only its owner may read it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import May, Name

ENDING: Final = ".iwid"
"""Ending of the names of these files."""
MAX_BYTES: Final = 65_536
"""Longest file."""


class IdentityFile(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", forbid_unknown_fields=True):
    """An identity.

    Attributes:
        identity: Version of the file.
        name: User name.
        password: Password, in plain text: the router must know it.
        connect: Endpoints of the router, for commands that are given none.
        may: What the lab's document allowed when the file was written, so that a denial can be put in words. The router
            decides, and says nothing.
    """

    identity: Literal["iw.v1"] = "iw.v1"
    name: Name
    password: Annotated[str, Meta(min_length=8, max_length=200, pattern="^[!-9;-~]+$")]
    connect: tuple[str, ...] = ()
    may: tuple[May, ...] = ()

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
