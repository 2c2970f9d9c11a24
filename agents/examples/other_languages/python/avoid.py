"""A chair that avoids obstacles. It needs only zenoh and JSON. Usage: avoid.py [NAME [ENDPOINT]]."""

import json
import queue
import secrets
import sys
import time
from typing import Any

import zenoh

NAME = sys.argv[1] if len(sys.argv) > 1 else "avoid1"
KEY, JSON, INSTANCE = "iw/v1/main", "application/json", secrets.token_hex(8)
EYES = {"left": 35.0, "front": 0.0, "right": -35.0}
EYE = {"X": 0.6, "Y": 0.0, "Z": 0.4, "ConeDeg": 40.0, "MaxRange": 3.0}
PROXIMITY = [{"Id": eye, "DirectionDeg": angle, **EYE} for eye, angle in EYES.items()]
BODY = {"Length": 1.1, "Width": 0.6, "Center": 0.4, "TopSpeed": 1.0, "Track": 0.57}
ROBOT = {"Kind": "wheelchair", "Instance": INSTANCE, **BODY, "Proximity": PROXIMITY}


def connect() -> zenoh.Session:
    """Return a Zenoh session; try again until the endpoint answers."""
    endpoints = sys.argv[2:3] or ["tcp/127.0.0.1:7447"]
    settings = {"mode": "client", "connect": {"endpoints": endpoints}, "scouting": {"multicast": {"enabled": False}}}
    config = zenoh.Config.from_json5(json.dumps(settings))
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError:
            time.sleep(1.0)


def join(session: zenoh.Session) -> str:
    """Return the Session from Joined, or an empty string if there is no simulator."""
    for reply in session.get(f"{KEY}/join/{NAME}", payload=json.dumps(ROBOT), encoding=JSON, timeout=12.0):
        if reply.ok is not None:
            return str(json.loads(reply.ok.payload.to_bytes())["Session"])
        if reply.err is not None and str(reply.err.encoding).startswith("application/json"):
            refused = json.loads(reply.err.payload.to_bytes())
            if refused["Code"] != "no-token":
                sys.exit(refused["Text"])
            time.sleep(0.2)  # our token has not arrived yet
            return join(session)
    return ""


def drive(measures: dict[str, Any]) -> dict[str, float]:
    """Return the motor powers for the sensor readings."""
    # A reading without a Value has the Status `none` (nothing within 3 m) or `near` (touching).
    readings = {reading["Id"]: reading for reading in measures["Sensors"]["Proximity"]}
    see = {eye: r.get("Value", 0.0 if r.get("Status") == "near" else 3.0) for eye, r in readings.items()}
    free = min(see.values())
    forward = min(0.5, 0.5 * (free - 0.5)) if free > 0.5 else 0.0
    turn = 0.15 * (see["left"] - see["right"]) if free > 0.5 else 0.3
    return {"LeftMotor": forward - turn, "RightMotor": forward + turn}


arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
with (
    connect() as session,
    session.declare_subscriber(f"{KEY}/out/{NAME}/*", arrived.put),
    session.liveliness().declare_token(f"{KEY}/in/{NAME}/alive/both/{INSTANCE}"),
    session.declare_publisher(
        f"{KEY}/in/{NAME}/actions",
        encoding=JSON,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=zenoh.Priority.INTERACTIVE_HIGH,
    ) as actions,
    # The simulator's token appears when it starts, and again after a restart. We join each time.
    session.liveliness().declare_subscriber(f"{KEY}/alive", arrived.put, history=True),
):
    ours, run, tick = "", "", 0
    while True:
        sample = arrived.get()
        kind = str(sample.key_expr).rpartition("/")[2]
        if kind == "alive":
            ours = join(session) if sample.kind == zenoh.SampleKind.PUT else ""
            continue
        message = json.loads(sample.payload.to_bytes())
        if kind == "error":
            sys.stderr.write(message["Text"] + "\n")
            if message["Code"] in ("not-joined", "session"):
                ours = join(session)
        elif kind == "measures" and ours and (message["Run"] != run or message["Tick"] >= tick):
            run, tick = message["Run"], message["Tick"]
            said = {"Run": run, "Session": ours, "Tick": tick, "Seq": tick}
            actions.put(json.dumps(said | drive(message)))
