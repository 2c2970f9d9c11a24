from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_server.service.lab_files import LabFiles, router_until


def test_files_are_beside_the_lab(tmp_path: Path) -> None:
    files = LabFiles(tmp_path / "room3.xml")
    assert files.users == tmp_path / "room3.users"
    assert files.router_key == tmp_path / "room3.router.key"
    assert router_until(files) is None
    files.router.write_text("-----BEGIN CERTIFICATE-----\n")
    with pytest.raises(WireError, match="expected the certificate that iw-lab keys makes"):
        router_until(files)
