"""`iw-lab`: passwords and identity files for the people and programs of a lab."""

from __future__ import annotations

import argparse
import secrets
import sys
from collections.abc import Sequence
from pathlib import Path

from intellwheels_schemas.command_parser import CommandParser, readable_file
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import ENDING, IdentityFile, identity_text, write_secret
from intellwheels_schemas.messages import Lab
from intellwheels_schemas.process import add_process_options
from intellwheels_server.service.lab_router import read_lab, read_users, users_file

RESTART = "restart iw-router, as it reads names and passwords when it starts"


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-lab",
        description="Make passwords for the identities of a lab. The router reads them from the file beside the lab.",
    )
    actions = found.add_subparsers(dest="action", metavar="ACTION")
    keys = actions.add_parser("keys", help="make a password for each identity that has none, and drop those of others")
    invite = actions.add_parser("invite", help="write the identity file of one identity, for --identity of any command")
    invite.add_argument("name", metavar="NAME", help="the identity, as in the lab's document")
    revoke = actions.add_parser("revoke", help="give an identity another password, so that its old file is void")
    revoke.add_argument("name", metavar="NAME", help="the identity, as in the lab's document")
    for one in (keys, invite, revoke):
        one.add_argument(
            "--lab", type=readable_file, default=Path("LAB.xml"), metavar="FILE", help="the lab (default: LAB.xml)"
        )
    invite.add_argument("--out", type=Path, metavar="FILE", help=f"file to write (default: NAME{ENDING})")
    invite.add_argument(
        "--connect", action="append", default=[], metavar="ENDPOINT", help="endpoint of the router, as others reach it"
    )
    add_process_options(found)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 failed, 2 wrong usage."""
    command = parser()
    options = command.parse_args(arguments)
    if options.action is None:
        command.error("ACTION: expected keys, invite or revoke, got none")
    try:
        lab = read_lab(options.lab)
        _check(options, lab)
        return _do(options, lab)
    except WireError as error:
        _log(str(error))
        return 2
    except OSError as error:
        _log(f"{error.filename}: {error.strerror}")
        return 1


def _check(options: argparse.Namespace, lab: Lab) -> None:
    if options.action != "keys" and options.name not in {identity.name for identity in lab.identity}:
        raise WireError("value", f"NAME: expected an identity of {options.lab}, got '{options.name}'")
    for endpoint in getattr(options, "connect", ()):
        check_endpoint(endpoint, "--connect")


def _do(options: argparse.Namespace, lab: Lab) -> int:
    file = users_file(options.lab)
    before = read_users(file) if file.exists() else {}
    users = {identity.name: before.get(identity.name) or _new_password() for identity in lab.identity}
    if options.action == "revoke":
        users[options.name] = _new_password()
    if users != before:
        write_secret(file, "".join(f"{name}:{password}\n" for name, password in users.items()).encode("ascii"))
        _print(f"wrote users={len(users)} file={file}")
        _log(RESTART)
    if options.action == "invite":
        out = options.out or Path(f"{options.name}{ENDING}")
        (may,) = [identity.may for identity in lab.identity if identity.name == options.name]
        own = IdentityFile(name=options.name, password=users[options.name], connect=tuple(options.connect), may=may)
        write_secret(out, identity_text(own))
        _print(f"wrote identity={options.name} file={out}")
    return 0


def _new_password() -> str:
    return secrets.token_urlsafe(24)


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


def _log(line: str) -> None:
    print(f"iw-lab: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log


if __name__ == "__main__":
    sys.exit(main())
