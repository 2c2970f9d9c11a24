"""The version is that of the installed distribution."""

from importlib.metadata import version

from intellwheels_schemas.version import installed_version, version_text


def test_version_is_that_of_the_distribution() -> None:
    assert installed_version("msgspec") == version("msgspec")


def test_distribution_that_is_not_installed_is_unknown() -> None:
    assert installed_version("no-such-distribution") == "unknown"


def test_text_names_the_product_and_the_zenoh_library() -> None:
    assert version_text() == f"intellwheels {installed_version()} (eclipse-zenoh {version('eclipse-zenoh')})"
