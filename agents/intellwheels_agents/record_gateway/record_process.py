"""One `iw-record`, from its start to its end."""

from __future__ import annotations

import argparse
import socket
import sys
import threading
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from intellwheels_agents.record_gateway import record_options
from intellwheels_agents.record_gateway.log_source import WORLD, LogSteps, playing
from intellwheels_agents.record_gateway.message_sinks import MessageSinks
from intellwheels_agents.record_gateway.panel_driver import PanelDriver
from intellwheels_agents.record_gateway.publish_panel import PublishPanel
from intellwheels_agents.record_gateway.translator import Translator
from intellwheels_agents.record_gateway.world_source import WorldSource
from intellwheels_schemas import link, own_rights
from intellwheels_schemas.json_schema import json_schemas
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.session_closing import closing

if TYPE_CHECKING:
    from intellwheels_agents.record_gateway.bag_writer import BagWriter

HOLD = 0.5
"""Seconds for which a published input drives a chair."""
LOG_CONNECT = 20.0
"""Seconds to connect to the simulator that plays a log."""


def record(given: argparse.Namespace, where: link.Link, stop: threading.Event) -> int:
    """Record until `stop` is set or the log is at its end, and return the exit code.

    Args:
        given: The options.
        where: The link to the world; not used with a log.
        stop: Set when the process must end.

    Raises:
        ConnectionError: The world could not be reached, or a log not be played.
        OSError: A file could not be written, or the live view not be served.
    """
    panel = PublishPanel(HOLD if given.hold is None else given.hold)
    most = round(1e6 * (record_options.ROTATE if given.rotate is None else given.rotate))
    with ExitStack() as stack:
        complaints = None
        timeout: float | None = None if given.retry_for > 1e9 else given.retry_for
        if given.log is not None:
            endpoint = f"tcp/127.0.0.1:{_free_port()}"
            complaints = stack.enter_context(playing(given.log, endpoint, stop))
            where, timeout = link.Link(WORLD, connect=(endpoint,)), LOG_CONNECT
        keys = Keys(where.world)
        translator = Translator(keys, time.time if given.log is None else _zero)
        bag = None if given.ros2 is None else _bag(given, keys, translator)
        sinks = MessageSinks(json_schemas(grows=True), given.file, most, overwrite=given.overwrite)
        try:
            port = None
            if given.live:
                host = given.host or record_options.HOST
                wanted = record_options.PORT if given.port is None else given.port
                port = sinks.serve(f"IntellWheels {where.world}", host, wanted, panel)
            session = link.open_session(where, stop, timeout=timeout, waiting=lambda why: _log(f"waiting why={why!r}"))
            if session is None:
                return 0
            source = WorldSource(session, keys, translator, sinks.write, _log, others=() if bag is None else (bag,))
            with closing(session), source:
                words = [] if given.file is None else [f"file={given.file}"]
                words += [] if given.ros2 is None else [f"bag={given.ros2}"]
                words += [] if port is None else [f"live=ws://{given.host or record_options.HOST}:{port}"]
                _print(f"ready {' '.join(words)}")
                if denied := own_rights.denied(session, keys.every_state, "read"):
                    _log(f"waiting why={denied!r}")
                if given.log is not None:
                    LogSteps(session, keys, source, translator).run(stop, sinks.tend)
                else:
                    _follow(given, session, keys, source, translator, sinks, panel, stop)
                dropped = source.inbox.dropped
        finally:
            with ExitStack() as ending:
                if bag is not None:
                    ending.callback(bag.close)
                sinks.close({
                    "ticks": str(translator.ticks.seen), "missed": str(translator.ticks.missed),
                    "refused": str(translator.refused), "world": where.world,
                })  # fmt: skip
        _print(
            f"recorded {'' if given.file is None else f'file={given.file} '}files={len(sinks.files)} "
            f"{'' if bag is None else f'bag={given.ros2} bag_messages={bag.messages} '}"
            f"messages={sinks.messages} ticks={translator.ticks.seen} missed={translator.ticks.missed} "
            f"refused={translator.refused + dropped}"
        )
        for agent, why in bag.refused.items() if bag is not None else ():
            _log(f"left out of the bag agent={agent} why={why!r}")
        for line in complaints() if complaints is not None else ():
            _log(line)
    return 0


def _follow(
    given: argparse.Namespace, session: Any, keys: Keys, source: WorldSource, translator: Translator,
    sinks: MessageSinks, panel: PublishPanel, stop: threading.Event,
) -> None:  # fmt: skip
    """Record a world until `stop` is set."""
    driver = PanelDriver(session, keys, panel, take=bool(given.take), log=_log)
    while not stop.is_set():
        source.work(stop)
        if given.live:
            driver.work(translator.robots, time.monotonic())
            for topic in panel.subscribed(time.monotonic()):
                sinks.repeat(topic)
        sinks.tend()


def _bag(given: argparse.Namespace, keys: Keys, translator: Translator) -> BagWriter:
    # Both need the extra `ros`.
    from intellwheels_agents.record_gateway.bag_writer import BagWriter  # noqa: PLC0415
    from intellwheels_agents.record_gateway.ros_translator import RosTranslator  # noqa: PLC0415

    return BagWriter(given.ros2, given.storage or record_options.STORAGES[0], RosTranslator(keys, translator))


def _zero() -> float:
    return 0.0


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - scripts wait for these lines


def _log(line: str) -> None:
    print(f"iw-record: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log
