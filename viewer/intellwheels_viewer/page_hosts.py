"""The names and addresses of the page, and which requests are for our own page."""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Iterable
from typing import Final, NamedTuple

from intellwheels_schemas.errors import WireError

LOOPBACK: Final = ("localhost", "127.0.0.1", "::1")
"""Names by which a browser on this machine reaches the page."""
EVERYWHERE: Final = frozenset({"0.0.0.0", "::"})  # noqa: S104 - to compare with
"""Addresses that stand for all addresses of this machine; no browser reaches the page by them."""
_PORTS: Final = {"http": 80, "https": 443}
_LAST_PORT: Final = 65535

_NAME = r"[A-Za-z0-9_](?:[A-Za-z0-9._-]*[A-Za-z0-9])?"
_BARE: Final = re.compile(rf"{_NAME}|[0-9A-Fa-f]*(?::[0-9A-Fa-f.]*){{2,}}")
"""A host name or an IP address, without a port. An address with a colon has at least two."""
_SITE: Final = re.compile(rf"({_NAME}|\[[0-9A-Fa-f:.]+\])(?::([0-9]{{1,5}}))?")
"""A `Host` header, or an `Origin` without its scheme."""


class Site(NamedTuple):
    """A host name in lower case, or an IP address in its short form, and a port; None for no port."""

    name: str
    port: int | None = None


class PageNames(NamedTuple):
    """By which names browsers reach the page.

    Attributes:
        ours: Those by which requests may come. Without a port, any port counts.
        sites: Those of `--allow-host`: where a proxy may show the page under a name that it then replaces. Without a
            port, only the usual ports of http and https count.
    """

    ours: frozenset[Site]
    sites: frozenset[Site] = frozenset()


def page_names(host: str, allowed: Iterable[str] = ()) -> PageNames:
    """Return the names of a page that is served at `host`, with those of `--allow-host`.

    Raises:
        WireError: A name of `--allow-host` has another form.
    """
    sites = frozenset(_allowed(name) for name in allowed)
    own = () if host in EVERYWHERE else (host,)
    return PageNames(sites | {Site(_short(name)) for name in (*LOOPBACK, *own)}, sites)


def site_of(text: str) -> Site | None:
    """Return the site of a `Host` header; None if it has another form."""
    found = _SITE.fullmatch(text)
    if found is None or (found[2] and int(found[2]) > _LAST_PORT):
        return None
    return Site(_short(found[1].strip("[]")), int(found[2]) if found[2] else None)


def refusal(host: str | None, origin: str | None, names: PageNames) -> str | None:
    """Return why a request is refused, or None if it is accepted. Origins are compared as RFC 6454 says.

    Args:
        host: The `Host` header.
        origin: The `Origin` header; programs other than browsers send none.
        names: The names of the page.
    """
    site = site_of(host or "")
    if site is None or not any(_is_at(site, ours) for ours in names.ours):
        wanted = ", ".join(sorted({ours.name for ours in names.ours}))
        return f"Host: expected one of {wanted}, got {host!r}; see --allow-host"
    if origin is None:
        return None
    scheme, _, rest = origin.partition("://")
    default, theirs = _PORTS.get(scheme), site_of(rest)
    if default is None or theirs is None:
        return f"Origin: expected this page's own, {host!r}, got {origin!r}"
    theirs = Site(theirs.name, theirs.port or default)
    # The scheme of our own page is not known: a proxy may have ended TLS.
    if theirs == Site(site.name, site.port or default):
        return None
    if any(theirs == Site(allowed.name, allowed.port or default) for allowed in names.sites):
        return None
    return f"Origin: expected this page's own, {host!r}, got {origin!r}; see --allow-host"


def is_wide(host: str) -> bool:
    """Return whether other machines can reach a page that is served at an address."""
    try:
        return not ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() != "localhost"


def url_of(host: str, port: int) -> str:
    """Return the URL of a page that is served at an address, for a browser on this machine."""
    name = "localhost" if host in EVERYWHERE else host
    return f"http://[{name}]:{port}" if ":" in name else f"http://{name}:{port}"


def check_page_hosts(host: str, allowed: Iterable[str]) -> None:
    """Check where the page is served, and by which names browsers may reach it.

    Raises:
        WireError: `--host` is no address of this machine, or a name of `--allow-host` has another form.
    """
    for name in allowed:
        _allowed(name)
    if not _is_here(host):
        text = f"--host: expected an address of this machine, such as 127.0.0.1 or 0.0.0.0, got {host!r}"
        raise WireError("value", text, "--host")


def _is_at(site: Site, ours: Site) -> bool:
    """Return whether a `Host` header names one of our sites; browsers leave out the usual ports."""
    if ours.port is None or site.name != ours.name:
        return site.name == ours.name
    return site.port == ours.port or (site.port is None and ours.port in _PORTS.values())


def _allowed(name: str) -> Site:
    found = Site(_short(name)) if _BARE.fullmatch(name) is not None else site_of(name)
    if found is None:
        text = f"--allow-host: expected a host name such as lab-pc, perhaps with a port, got {name!r}"
        raise WireError("value", text, "--allow-host")
    return found


def _short(name: str) -> str:
    try:
        return ipaddress.ip_address(name).compressed
    except ValueError:
        return name.lower()


def _is_here(host: str) -> bool:
    if _BARE.fullmatch(host) is None:
        return False
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.bind(address)
    except OSError:
        return False
    return True
