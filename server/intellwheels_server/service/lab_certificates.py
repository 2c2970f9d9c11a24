"""The certificates of a lab: its authority, its router, and its identities. Only this file knows `cryptography`.

The authority's key signs, and never leaves the folder of the lab. The router's certificate begins with a line
`Until: DATE`, which readers of PEM skip: so a router needs no library to see when its certificate ends.
"""

from __future__ import annotations

import datetime
import ipaddress
from dataclasses import dataclass
from typing import Final, NamedTuple

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import write_secret
from intellwheels_server.service.lab_files import LabFiles, router_until

AUTHORITY_DAYS: Final = 3650
ROUTER_DAYS: Final = 730
RENEW_DAYS: Final = 30
"""Days before its end on which the router's certificate is made anew."""
ALWAYS: Final = ("localhost", "127.0.0.1", "::1")
"""Names of the router that its certificate always has."""


class Issued(NamedTuple):
    """A certificate and its private key, as PEM."""

    certificate: str
    key: str


@dataclass(frozen=True)
class Authority:
    """What signs the certificates of a lab."""

    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    @property
    def pem(self) -> str:
        """The certificate as PEM."""
        return _pem(self.certificate)


def authority_of(files: LabFiles, name: str, today: datetime.date) -> Authority:
    """Return the authority of a lab, made if there is none.

    Args:
        files: The files of the lab.
        name: Name of the lab.
        today: The day in UTC.

    Raises:
        WireError: A file of it is none; the text never shows what is in it.
        OSError: The folder cannot be written.
    """
    if not files.authority.exists():
        key = ec.generate_private_key(ec.SECP256R1())
        subject = _name(f"{name} authority")
        end = today + datetime.timedelta(days=AUTHORITY_DAYS)
        certificate = (
            _builder(subject, subject, key.public_key(), today, end)
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(_usage(signs=True), critical=True)
            .sign(key, hashes.SHA256())
        )
        write_secret(files.authority_key, _key_pem(key).encode())
        write_secret(files.authority, _pem(certificate).encode())
        return Authority(certificate, key)
    try:
        found = x509.load_pem_x509_certificate(files.authority.read_bytes())
        loaded = serialization.load_pem_private_key(files.authority_key.read_bytes(), None)
    except (ValueError, TypeError):
        loaded = None
    if not isinstance(loaded, ec.EllipticCurvePrivateKey):
        where = str(files.authority_key)
        raise WireError("value", f"{where}: expected the authority that iw-lab keys made, got something else", where)
    return Authority(found, loaded)


def ensure_router(files: LabFiles, authority: Authority, hosts: tuple[str, ...], today: datetime.date) -> bool:
    """Make the router's certificate if there is none for these hosts, or if it ends soon; return whether it was made.

    Args:
        files: The files of the lab.
        authority: What signs.
        hosts: Names and addresses under which others reach the router, besides this machine's own. Older ones stay.
        today: The day in UTC.

    Raises:
        OSError: The folder cannot be written.
    """
    known = router_hosts(files)
    end = router_until(files)
    if known >= {*ALWAYS, *hosts} and end is not None and (end - today).days > RENEW_DAYS:
        return False
    until = today + datetime.timedelta(days=ROUTER_DAYS)
    names = sorted({*ALWAYS, *hosts, *known})
    issued = _issue(authority, "router", until, today, names)
    write_secret(files.router_key, issued.key.encode())
    write_secret(files.router, f"Until: {until}\n{issued.certificate}".encode())
    return True


def router_hosts(files: LabFiles) -> set[str]:
    """Return the names and addresses in the router's certificate; none without one."""
    if not files.router.exists():
        return set()
    try:
        certificate = x509.load_pem_x509_certificate(files.router.read_bytes())
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (ValueError, x509.ExtensionNotFound):
        return set()
    return {*names.get_values_for_type(x509.DNSName), *map(str, names.get_values_for_type(x509.IPAddress))}


def issue_for(authority: Authority, name: str, until: datetime.date, today: datetime.date) -> Issued:
    """Return a certificate for an identity, which counts up to a day, in UTC, inclusive."""
    return _issue(authority, name, until, today, [])


def _issue(authority: Authority, name: str, until: datetime.date, today: datetime.date, hosts: list[str]) -> Issued:
    key = ec.generate_private_key(ec.SECP256R1())
    usage = ExtendedKeyUsageOID.SERVER_AUTH if hosts else ExtendedKeyUsageOID.CLIENT_AUTH
    builder = (
        _builder(_name(name), authority.certificate.subject, key.public_key(), today, until)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([usage]), critical=False)
        .add_extension(_usage(signs=False), critical=True)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(authority.key.public_key()), critical=False)
    )
    if hosts:
        builder = builder.add_extension(x509.SubjectAlternativeName([_host(host) for host in hosts]), critical=False)
    return Issued(_pem(builder.sign(authority.key, hashes.SHA256())), _key_pem(key))


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, today: datetime.date, until: datetime.date
) -> x509.CertificateBuilder:
    # A day earlier, for clocks that are behind; and to the end of the last day.
    begin, end = min(today, until) - datetime.timedelta(days=1), until + datetime.timedelta(days=1)
    midnight = datetime.time(tzinfo=datetime.UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(datetime.datetime.combine(begin, midnight))
        .not_valid_after(datetime.datetime.combine(end, midnight))
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key), critical=False)
    )


def _usage(*, signs: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs, key_cert_sign=signs, crl_sign=signs, content_commitment=False,
        key_encipherment=False, data_encipherment=False, key_agreement=False, encipher_only=False, decipher_only=False,
    )  # fmt: skip


def _host(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])


def _pem(certificate: x509.Certificate) -> str:
    return certificate.public_bytes(serialization.Encoding.PEM).decode()


def _key_pem(key: ec.EllipticCurvePrivateKey) -> str:
    form = serialization.PrivateFormat.PKCS8
    return key.private_bytes(serialization.Encoding.PEM, form, serialization.NoEncryption()).decode()
