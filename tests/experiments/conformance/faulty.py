"""An agent with one fault, for the check: `faulty.py FAULT NAME ENDPOINT`. With the fault `none` it has none."""

from __future__ import annotations

import json
import queue
import secrets
import signal
import sys
import threading
import time
from typing import Any

import zenoh

FAULT, NAME, ENDPOINT = sys.argv[1:4]
KEY, JSON, INSTANCE = "iw/v1/main", "application/json", secrets.token_hex(8)
ROBOT = {"Instance": INSTANCE, "TopSpeed": 1.0, "Length": 1.0, "Width": 0.6, "Encoders": [{"Id": "wheels"}]}
KNOWN = {"Run", "Tick", "Time", "Collision", "Contact", "Sensors", "Message", "UserInput"}


def configuration() -> zenoh.Config:
    config = zenoh.Config()
    for name, value in (
        ("mode", "client"),
        ("connect/endpoints", [ENDPOINT]),
        ("scouting/multicast/enabled", False),
    ):
        config.insert_json5(name, json.dumps(value))
    return config


def main() -> None:
    told_to_end = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: told_to_end.set())
    arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
    with (
        zenoh.open(configuration()) as session,
        session.declare_subscriber(f"{KEY}/out/{NAME}/measures", arrived.put),
        session.liveliness().declare_token(f"{KEY}/in/{NAME}/alive/both/{INSTANCE}"),
        session.declare_publisher(
            f"{KEY}/in/{NAME}/actions",
            encoding=JSON,
            congestion_control=zenoh.CongestionControl.BLOCK if FAULT == "blocks" else zenoh.CongestionControl.DROP,
        ) as actions,
        session.liveliness().declare_subscriber(f"{KEY}/alive", arrived.put, history=True),
    ):
        ours: dict[str, Any] = {}
        run, tick, left = "", -1, False
        while True:
            if told_to_end.is_set() and not left:
                left = True
                list(session.get(f"{KEY}/leave/{NAME}", timeout=2.0))
                if FAULT != "drives-on":
                    return
            try:
                sample = arrived.get(timeout=0.1)
            except queue.Empty:
                continue
            if str(sample.key_expr).endswith("/alive"):
                if sample.kind == zenoh.SampleKind.PUT:
                    ours = join(session)
                    run, tick = ours.get("Run", ""), -1
                continue
            measures = json.loads(sample.payload.to_bytes())
            if FAULT == "refuses-unknown-fields" and not measures.keys() <= KNOWN:
                continue
            if FAULT != "ignores-run" and measures["Run"] != run:
                run, tick = measures["Run"], -1
            if measures["Tick"] < tick and FAULT != "answers-old-ticks":
                continue
            tick = measures["Tick"]
            answer = {"Run": run, "Session": ours["Session"]} if ours else {}
            actions.put(json.dumps(answer | {"Tick": tick, "LeftMotor": 0.2, "RightMotor": 0.2}))


def join(session: zenoh.Session) -> dict[str, Any]:
    while True:
        for reply in session.get(f"{KEY}/join/{NAME}", payload=json.dumps(ROBOT), encoding=JSON):
            if reply.ok is not None:
                joined: dict[str, Any] = json.loads(reply.ok.payload.to_bytes())
                return joined
            assert reply.err is not None
            refused = json.loads(reply.err.payload.to_bytes())
            print(refused["Text"], flush=True)
            if refused["Code"] == "no-token":
                time.sleep(0.1)
                return join(session)
            if FAULT == "ignores-refusal":
                return {}
            sys.exit(1)


main()
