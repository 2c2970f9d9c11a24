from __future__ import annotations

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_viewer.page_hosts import check_page_hosts


def test_addresses_and_names_are_accepted() -> None:
    check_page_hosts("127.0.0.1", [])
    check_page_hosts("0.0.0.0", ["lab-pc", "lab.example.org", "10.0.0.5", "fe80::1"])


@pytest.mark.parametrize("host", ["", "http://127.0.0.1", "127.0.0.1:80", "192.0.2.1", "no host"])
def test_what_is_no_address_of_this_machine_is_refused(host: str) -> None:
    with pytest.raises(WireError, match=r"^--host: expected an address of this machine, .*, got "):
        check_page_hosts(host, [])


@pytest.mark.parametrize("name", ["", "http://lab-pc", "lab-pc:8080", "a b"])
def test_a_name_has_no_port_and_no_scheme(name: str) -> None:
    with pytest.raises(WireError, match=r"^--allow-host: expected a host name such as lab-pc, without a port, got "):
        check_page_hosts("127.0.0.1", ["lab-pc", name])
