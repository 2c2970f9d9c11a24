"""The simulator with one thing changed: measures wait for room instead of being dropped. For comparison only."""

from __future__ import annotations

import sys

import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.channels import Channel
from intellwheels_schemas.codec import Encoding
from intellwheels_server.__main__ import main

_declare = link.declare


def declare(session: zenoh.Session, key: str, channel: Channel, encoding: Encoding = Encoding.JSON) -> zenoh.Publisher:
    """Return a publisher that blocks, express, for measures; the usual one for all else."""
    if not key.endswith("/measures"):
        return _declare(session, key, channel, encoding)
    return session.declare_publisher(
        key,
        encoding=zenoh.Encoding(encoding.value),
        congestion_control=zenoh.CongestionControl.BLOCK,
        priority=zenoh.Priority.DATA_HIGH,
        express=True,
    )


if __name__ == "__main__":
    link.declare = declare
    sys.exit(main())
