from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_server.service.lab_files import LabFiles, read_lab, router_until


def test_files_are_beside_the_lab(tmp_path: Path) -> None:
    files = LabFiles(tmp_path / "room3.xml")
    assert files.users == tmp_path / "room3.users"
    assert files.router_key == tmp_path / "room3.router.key"
    assert router_until(files) is None
    files.router.write_text("-----BEGIN CERTIFICATE-----\n")
    with pytest.raises(WireError, match="expected the certificate that iw-lab keys makes"):
        router_until(files)


def test_secrets_that_others_can_read_are_named_with_what_to_do(tmp_path: Path) -> None:
    files = LabFiles(tmp_path / "room3.xml")
    assert files.exposed() == []
    for secret, mode in ((files.users, 0o640), (files.authority_key, 0o600), (files.router_key, 0o604)):
        secret.write_text("secret")
        secret.chmod(mode)
    assert files.exposed() == [
        f"{secret}: others can read this secret; run chmod 600 {secret}" for secret in (files.users, files.router_key)
    ]


@pytest.mark.parametrize("verbs", ['Verbs=""', "Verbs = ' '"])
def test_empty_list_of_verbs_is_refused_as_it_would_mean_all(tmp_path: Path, verbs: str) -> None:
    path = tmp_path / "lab.xml"
    may = f'<May Role="operator" {verbs}/>'
    path.write_text(f'<Lab Format="iw.v1" Name="l">\n<Identity Name="op">{may}</Identity></Lab>')
    with pytest.raises(WireError, match=r"lab\.xml:2: Verbs: expected verbs, or no Verbs for all of them"):
        read_lab(path)
    path.write_text(path.read_text().replace(verbs, 'Verbs="pause"'))
    assert read_lab(path).identity[0].may[0].verbs == ("pause",)
