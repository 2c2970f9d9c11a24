"""Under which names the page is served, and which requests are for it."""

from __future__ import annotations

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_viewer.page_hosts import (
    PageNames,
    Site,
    check_page_hosts,
    is_wide,
    page_names,
    refusal,
    site_of,
    url_of,
)
from tests.every_case import every_case

OURS = page_names("127.0.0.1", ["lab-pc"])


def test_addresses_and_names_are_accepted() -> None:
    check_page_hosts("127.0.0.1", [])
    check_page_hosts("0.0.0.0", ["lab-pc", "lab.example.org", "10.0.0.5", "fe80::1", "lab-pc:8443", "[fe80::1]:8443"])


@pytest.mark.parametrize("host", ["", "http://127.0.0.1", "127.0.0.1:80", "192.0.2.1", "no host"])
def test_what_is_no_address_of_this_machine_is_refused(host: str) -> None:
    with pytest.raises(WireError, match=r"^--host: expected an address of this machine, .*, got "):
        check_page_hosts(host, [])


@pytest.mark.parametrize("name", ["", "http://lab-pc", "lab-pc:x", "lab-pc:99999", "a b", "a@b", "lab-pc/x"])
def test_name_has_no_scheme_and_no_path(name: str) -> None:
    with pytest.raises(
        WireError, match=r"^--allow-host: expected a host name such as lab-pc, perhaps with a port, got "
    ):
        check_page_hosts("127.0.0.1", ["lab-pc", name])


@every_case(
    ("text", "site"),
    [
        ("localhost", Site("localhost")),
        ("LocalHost:8080", Site("localhost", 8080)), ("[::1]:8080", Site("::1", 8080)),
        ("[0:0:0:0:0:0:0:1]", Site("::1")), ("127.0.0.1:1", Site("127.0.0.1", 1)), ("", None), ("[::1", None),
        ("localhost:1@evil.example", None), ("localhost/x", None), ("::1", None),
    ],
)  # fmt: skip
def test_host_is_a_name_and_perhaps_a_port(text: str, site: Site | None) -> None:
    assert site_of(text) == site


@every_case(
    "host",
    ["evil.example", "localhost.evil.example", "evil.example:8080", "127.0.0.1.evil.example", "0.0.0.0:8080", "",
     None, "localhost.", "[::1", "localhost:1@evil.example", "2130706433", "127.1"],
)  # fmt: skip
def test_host_that_is_not_ours_is_refused(host: str | None) -> None:
    assert "Host: expected one of" in (refusal(host, None, OURS) or "")


@every_case(
    "origin",
    ["http://evil.example", "https://localhost.evil.example:8080", "null", "", "http://localhost:9999",
     "http://localhost", "file://", "http://localhost:8080,http://evil.example", "ftp://localhost:8080", "http://[",
     "http://127.0.0.1:8080", "http://localhost:8080@evil.example", "http://localhost:8080/", "http://lab-pc:8081"],
)  # fmt: skip
def test_origin_that_is_not_the_host_is_refused(origin: str) -> None:
    assert "Origin: expected this page's own" in (refusal("localhost:8080", origin, OURS) or "")


@every_case(
    ("host", "origin", "names"),
    [
        ("localhost:8080", None, OURS),
        ("localhost:8080", "http://localhost:8080", OURS),
        ("localhost:8080", "https://LOCALHOST:8080", OURS),
        # A port that the scheme implies is left out by browsers, and written by some proxies.
        ("site:443", "https://site", page_names("127.0.0.1", ["site"])),
        ("site", "https://site", page_names("127.0.0.1", ["site"])),
        ("site:80", "http://site", page_names("127.0.0.1", ["site"])),
        ("site", "https://site:443", page_names("127.0.0.1", ["site:443"])),
        ("site:8443", "https://site:8443", page_names("127.0.0.1", ["site:8443"])),
        # A proxy that writes its own Host.
        ("127.0.0.1:8080", "https://site", page_names("127.0.0.1", ["site"])),
        ("127.0.0.1:8080", "https://site:8443", page_names("127.0.0.1", ["site:8443"])),
        ("[::1]:8080", "http://[::1]:8080", page_names("::1")),
        ("[::1]:8080", "http://[0:0:0:0:0:0:0:1]:8080", page_names("0:0:0:0:0:0:0:1")),
        ("10.0.0.5:8080", "http://10.0.0.5:8080", page_names("10.0.0.5")),
    ],
)  # fmt: skip
def test_our_page_and_programs_are_welcome(host: str, origin: str | None, names: PageNames) -> None:
    assert refusal(host, origin, names) is None


@pytest.mark.parametrize(
    ("host", "origin", "allowed"),
    [
        ("site:9999", "https://site:9999", "site:8443"),
        ("site", None, "site:8443"),
        ("127.0.0.1:8080", "https://site:9999", "site"),
        ("127.0.0.1:8080", "https://site", "site:8443"),
    ],
)
def test_another_port_is_another_site(host: str, origin: str | None, allowed: str) -> None:
    assert refusal(host, origin, page_names("127.0.0.1", [allowed])) is not None


def test_url_of_an_address_of_version_6_has_brackets() -> None:
    assert url_of("::1", 8080) == "http://[::1]:8080"
    assert url_of("127.0.0.1", 8080) == "http://127.0.0.1:8080"
    assert url_of("::", 8080) == url_of("0.0.0.0", 8080) == "http://localhost:8080"


def test_what_other_machines_reach_is_wide() -> None:
    assert [is_wide(host) for host in ("127.0.0.1", "::1", "localhost", "0.0.0.0", "::", "10.0.0.5", "lab-pc")] == [
        False, False, False, True, True, True, True
    ]  # fmt: skip
