"""The other end of the wire for `tick`: takes everybody's measures, and sends everybody's actions when told."""

from __future__ import annotations

import socket
import sys
import threading

from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Actions


def endpoint() -> str:
    """Return a loopback endpoint that was free just now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def main() -> None:
    """Serve `tick`."""
    address, count, times = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    keys = Keys("bench")
    session = link.open_session(link.Link(connect=(address,)), threading.Event())
    assert session is not None
    with session, session.declare_subscriber(f"{keys.prefix}out/*/measures", lambda _sample: None):
        publishers = [link.declare(session, keys.actions(f"a{k:04d}"), CHANNELS["actions"]) for k in range(count)]
        payload = encode(
            Actions(run="0" * 16, session="0" * 16, tick=1, seq=1, left_motor=0.512345678, right_motor=0.412345678)
        )
        print("ready", flush=True)
        for _line in sys.stdin:
            for _ in range(times):
                for publisher in publishers:
                    publisher.put(payload)
            print("sent", flush=True)


if __name__ == "__main__":
    main()
