"""Costly maps while the world goes on: how soon a load is answered, and by how much a tick is delayed meanwhile."""

from __future__ import annotations

import json
import threading
import time

from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Clock, Result
from intellwheels_server.service.load_floor import LoadRequest, PackedFloor, load_floor
from tests.bench.network import WORLD, process, wait_for
from tests.bench.rows import Row
from tests.bench.sink import endpoint
from tests.bench.tick import best
from tests.e2e.costly_maps import MOST_CORNERS, SHAPES, crowded, load

SOLID = 2_000
"""Corners of a solid that is ready in less than a second."""
PERIOD = 0.05


def bench(*, corners: int = MOST_CORNERS, shapes: tuple[str, ...] = tuple(SHAPES), settle: float = 2.0) -> list[Row]:
    """Return the rows."""
    rows = []
    for shape in shapes:
        if shape == "knot":
            continue
        request = LoadRequest(json.dumps(load(shape, SOLID)).encode(), Encoding.JSON.value)
        assert isinstance(load_floor(request), PackedFloor)
        spent = best(lambda request=request: load_floor(request), 1, 3)  # type: ignore[misc]
        rows.append(Row("loads", f"{shape}, {SOLID} corners", "check and cut", spent, "s", "<= 1"))
    maps = [load(shape, corners) for shape in shapes]
    if len(shapes) == len(SHAPES):
        maps.append(crowded(3_000))
    address = endpoint()
    with process("intellwheels_server", "--map", "square", "--world", WORLD, "--listen", address) as simulator:
        wait_for(simulator, "ready")
        session = link.open_session(link.Link(connect=(address,)), threading.Event())
        assert session is not None
        inbox = zenoh_inbox.Inbox()
        with session, session.declare_subscriber(Keys(WORLD).clock, inbox.on_sample):
            threading.Event().wait(settle)  # the first ticks are not the rule
            quiet = _longest(inbox)
            longest = 0.0
            for wanted in maps:
                began = time.monotonic()
                answer = link.query(session, Keys(WORLD).ctl("load"), json.dumps(wanted).encode(), timeout=60.0)[0]
                longest = max(longest, time.monotonic() - began)
                assert decode(Result, answer.data, strict=False).code in ("ok", "failed")
            threading.Event().wait(0.5)
            busy = _longest(inbox)
    case = f"{len(maps)} maps of {corners} corners"
    rows.append(Row("loads", case, "longest wait for an answer", longest, "s", "<= 5"))
    rows.append(Row("loads", "no load", "longest delay of a tick", 1e3 * quiet, "ms", "<= 50"))
    rows.append(Row("loads", case, "longest delay of a tick", 1e3 * busy, "ms", "<= 50"))
    return rows


def _longest(inbox: zenoh_inbox.Inbox) -> float:
    """Return the longest time between two clocks that came, less the periods between them, s."""
    longest = 0.0
    before: Clock | None = None
    for arrival in inbox.take():
        assert isinstance(arrival, zenoh_inbox.Put)
        clock = decode(Clock, arrival.data, strict=False)
        if before is not None:
            ticks = clock.tick - before.tick if clock.run == before.run else 0
            longest = max(longest, clock.stamp - before.stamp - max(ticks, 1) * PERIOD)
        before = clock
    return longest
