"""`iw-lab`: makes passwords, certificates and identity files for the people and programs of a lab."""

from __future__ import annotations

import argparse
import datetime
import ipaddress
import re
import secrets
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_schemas.command_parser import CommandParser, readable_file
from intellwheels_schemas.endpoint_form import check_endpoint, host_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.files import write_file
from intellwheels_schemas.identity_file import ENDING, IdentityFile, identity_text, read_identity, write_secret
from intellwheels_schemas.lab_rules import check_lab, has_expired
from intellwheels_schemas.messages import Identity, Lab
from intellwheels_schemas.names import check_agent, check_name, check_word
from intellwheels_schemas.process import add_process_options
from intellwheels_server.service.lab_files import LabFiles, read_lab, read_users
from intellwheels_server.service.lab_template import new_lab

RESTART: Final = (
    "restart iw-router if it runs: it reads names, passwords and rules when it starts, and keeps old sessions till then"
)
DAYS: Final = 365
"""Days for which a certificate counts, unless the lab's document or an option says less."""
_STUDENTS: Final = re.compile(r"st[0-9]+-")
"""Beginnings of the agents of students in a new lab."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-lab",
        description="Make passwords and certificates for the identities of a lab. The router reads them from files "
        "beside the lab's document.",
        epilog="The document is described in schemas/KEYS.md (Lab, and `Who may do what`). Exit codes: 0 done, 1 "
        "failed, 2 wrong usage. To make certificates, it needs the extra `lab`.",
    )
    actions = found.add_subparsers(dest="action", metavar="ACTION")

    def action(name: str, does: str) -> argparse.ArgumentParser:
        return actions.add_parser(name, help=does, description=f"{does[0].upper()}{does[1:]}.")

    new = action("new", "write the document of a new lab, to start from")
    new.add_argument(
        "--students", type=_students, default=20, metavar="N",
        help="number of students, in [0, 1000] (default: 20)",
    )  # fmt: skip
    new.add_argument(
        "--chair", action="append", default=[], metavar="NAME", help="name of a real chair; may be repeated"
    )
    new.add_argument(
        "--lab", type=Path, default=Path("LAB.xml"), metavar="FILE", help="the lab's document (default: LAB.xml)"
    )
    keys = action(
        "keys",
        "make what is missing: passwords, and the certificates of the lab and its router; remove the passwords of "
        "identities that have expired or are no longer in the document",
    )
    keys.add_argument(
        "--host", action="append", default=[], type=_host, metavar="HOST",
        help="name or address by which other machines reach the router at a tls/ endpoint, put into its certificate; "
        "localhost, 127.0.0.1 and ::1 are always in it; may be repeated, and is remembered",
    )  # fmt: skip
    invite = action(
        "invite",
        "write identity files, for --identity of any command; make passwords, and the certificates of the lab and its "
        "router, if there are none",
    )
    renew = action(
        "renew", "write identity files again, with a later expiry date; old files are valid until they expire"
    )
    revoke = action(
        "revoke",
        "give an identity another password: its old file is void from the next restart of iw-router on, and invite "
        "writes the new one",
    )
    for one in (invite, renew):
        one.add_argument("names", nargs="*", metavar="NAME", help="identities, as in the lab's document (default: all)")
    revoke.add_argument("names", nargs="+", metavar="NAME", help="identities, as in the lab's document")
    for one in (keys, invite, renew, revoke):
        one.add_argument(
            "--lab", type=readable_file, default=Path("LAB.xml"), metavar="FILE",
            help="the lab's document (default: LAB.xml)",
        )  # fmt: skip
    for one in (invite, renew):
        one.add_argument(
            "--out", type=Path, metavar="FILE", help=f"file to write, with one NAME only (default: NAME{ENDING})"
        )
        one.add_argument(
            "--connect", action="append", default=[], metavar="ENDPOINT",
            help="endpoint of the router, as others reach it; may be repeated (default: those of the file if it "
            "exists, else none)",
        )  # fmt: skip
        one.add_argument(
            "--days", type=_days, default=DAYS, metavar="N",
            help=f"days for which the certificate is valid, in [1, {DAYS * 10}]; a password expires only after "
            f"the day `Until` of the lab's document, if given (default: {DAYS})",
        )  # fmt: skip
    add_process_options(found)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 failed, 2 wrong usage."""
    command = parser()
    options = command.parse_args(arguments)
    if options.action is None:
        command.error("ACTION: expected new, keys, invite, renew or revoke, got none")
    today = datetime.datetime.now(datetime.UTC).date()
    try:
        if options.action == "new":
            return _new(options)
        files = LabFiles(options.lab)
        for warning in files.exposed():
            _log(f"warning: {warning}")
        return _LabDesk(options, files, read_lab(options.lab), today).run()
    except WireError as error:
        _log(str(error))
        return 2
    except OSError as error:
        _log(f"{error.filename}: {error.strerror}")
        return 1


class _LabDesk:
    """One use of the command."""

    def __init__(self, options: argparse.Namespace, files: LabFiles, lab: Lab, today: datetime.date) -> None:
        self._options, self._files, self._lab, self._today = options, files, lab, today
        asked = [*options.host] if options.action == "keys" else []
        # A router at a tls/ endpoint has a certificate.
        encrypted = any(endpoint.startswith("tls/") for endpoint in getattr(options, "connect", ()))
        wanted = any(identity.certificate for identity in lab.identity)
        self._signs = bool(asked) or encrypted or wanted or files.authority.exists()

    def run(self) -> int:
        """Check everything, and do what was asked."""
        options = self._options
        named = [] if options.action == "keys" else [self._named(name) for name in options.names]
        for endpoint in getattr(options, "connect", ()):
            check_endpoint(endpoint, "--connect")
        lacking = missing_extra("lab") if self._signs else None
        if lacking is not None:
            raise WireError("value", f"certificates: {lacking}")
        if options.action == "keys":
            self._users()
            self._certificates(options.host)
        elif options.action == "revoke":
            self._users(revoked=[identity.name for identity in named])
            for identity in named:
                _print(f"revoked identity={identity.name}")
                _log(f"write a new file with iw-lab invite {identity.name}")
        else:
            everybody = [identity for identity in self._lab.identity if not has_expired(identity, self._today)]
            if options.out is not None and len(named) != 1:
                raise WireError("value", f"--out: expected with one NAME, got {len(named)}", "--out")
            for identity in named or everybody:
                self._invite(identity)
        return 0

    def _named(self, name: str) -> Identity:
        for index, identity in enumerate(self._lab.identity):
            if identity.name != name:
                continue
            if self._options.action != "revoke" and has_expired(identity, self._today):
                where = f"{self._options.lab}: Lab.Identity[{index}].Until"
                raise WireError("value", f"{where}: expected today or later to invite {name}, got {identity.until}")
            return identity
        raise WireError("value", f"NAME: expected an identity of {self._options.lab}, got '{name}'")

    def _users(self, revoked: Sequence[str] = ()) -> dict[str, str]:
        """Return the passwords of all, with new ones where needed."""
        file = self._files.users
        before = read_users(file) if file.exists() else {}
        users = {
            one.name: before.get(one.name, "") if one.name not in revoked else "" for one in self._lab.identity
            if not has_expired(one, self._today)
        }  # fmt: skip
        users = {name: password or secrets.token_urlsafe(24) for name, password in users.items()}
        if users != before:
            write_secret(file, "".join(f"{name}:{password}\n" for name, password in users.items()).encode("ascii"))
            _print(f"wrote users={len(users)} file={file}")
            _log(RESTART)
        return users

    def _certificates(self, asked: Sequence[str]) -> None:
        if not self._signs:
            return
        from intellwheels_server.service import lab_certificates as made  # noqa: PLC0415 - needs an extra

        authority = made.authority_of(self._files, self._lab.name, self._today)
        if made.ensure_router(self._files, authority, tuple(asked), self._today):
            hosts = ",".join(sorted(made.router_hosts(self._files)))
            _print(f"wrote certificate=router hosts={hosts} file={self._files.router}")
            _log("restart iw-router if it runs: it reads its certificate when it starts")

    def _invite(self, identity: Identity) -> None:
        options = self._options
        out = options.out or Path(f"{identity.name}{ENDING}")
        connect = tuple(options.connect) or (read_identity(out).connect if out.exists() else ())
        own = IdentityFile(
            name=identity.name, password="-" * 8, connect=connect, may=identity.may, lab=self._lab.name,
            until=identity.until,
        )  # fmt: skip
        if self._signs:
            own = self._certified(own)
        # Last, when nothing can be refused any more.
        password = self._users()[identity.name]
        write_secret(out, identity_text(msgspec.structs.replace(own, password=password)))
        _print(f"wrote identity={own.name} until={own.until or '-'} file={out}")

    def _certified(self, own: IdentityFile) -> IdentityFile:
        from intellwheels_server.service import lab_certificates as made  # noqa: PLC0415 - needs an extra

        reached = [host_of(endpoint) for endpoint in own.connect if endpoint.startswith("tls/")]
        if not self._files.router.exists():
            self._certificates(reached)
        hosts = made.router_hosts(self._files)
        for host in reached:
            if host not in hosts:
                got = f"{host}; run iw-lab keys --host {host} first"
                raise WireError("value", f"--connect: expected a host of the router's certificate, got {got}")
        authority = made.authority_of(self._files, self._lab.name, self._today)
        own = msgspec.structs.replace(own, authority=authority.pem)
        if not any(identity.certificate for identity in self._lab.identity):
            return own
        # The router then asks everybody on a tls/ endpoint for a certificate.
        until = self._today + datetime.timedelta(days=self._options.days)
        if own.until is not None:
            until = min(until, datetime.date.fromisoformat(own.until))
        issued = made.issue_for(authority, own.name, until, self._today)
        return msgspec.structs.replace(
            own, until=until.isoformat(), certificate=issued.certificate, private_key=issued.key
        )


def _new(options: argparse.Namespace) -> int:
    for chair in options.chair:
        check_agent(chair, "--chair")
        check_name(f"bridge-{chair}", "--chair: the name of its bridge")
        if _STUDENTS.match(chair):
            got = f"{chair}, which a student could drive"
            raise WireError("value", f"--chair: expected a name that does not begin with st1-, got {got}", "--chair")
    if options.lab.exists():
        raise WireError("value", f"--lab: expected a file that does not exist yet, got {options.lab}", "--lab")
    lab = new_lab(check_word(options.lab.stem.lower(), "--lab"), options.students, options.chair)
    check_lab(lab, "Lab")
    options.lab.write_text(write_file(lab), encoding="utf-8")
    _print(f"wrote identities={len(lab.identity)} file={options.lab}")
    return 0


def _host(text: str) -> str:
    try:
        return str(ipaddress.ip_address(text))
    except ValueError:
        # What an endpoint can have.
        if text and host_of(f"tls/{text}:1") == text:
            return text
    raise argparse.ArgumentTypeError(f"expected a host name or an address without a port, got {text!r}")


def _students(text: str) -> int:
    if text.isdecimal() and int(text) <= 1000:
        return int(text)
    raise argparse.ArgumentTypeError(f"expected a number of students from 0 to 1000, got {text!r}")


def _days(text: str) -> int:
    if text.isdecimal() and 0 < int(text) <= DAYS * 10:
        return int(text)
    raise argparse.ArgumentTypeError(f"expected a number of days from 1 to {DAYS * 10}, got {text!r}")


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


def _log(line: str) -> None:
    print(f"iw-lab: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log


if __name__ == "__main__":
    sys.exit(main())
