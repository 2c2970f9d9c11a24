import pytest

from intellwheels_schemas.present import main


@pytest.mark.process
def test_nobody_at_the_endpoint_is_not_present(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--connect", "tcp/127.0.0.1:1"]) == 1
    assert "nobody answers at tcp/127.0.0.1:1" in capsys.readouterr().err


def test_world_s_name_that_is_none_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--world", "a/b"]) == 2
    assert "--world: expected a name" in capsys.readouterr().err
