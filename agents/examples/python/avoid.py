"""A chair that keeps out of the way, without the harness: zenoh and JSON are all it needs. Usage: avoid.py [NAME]."""

import json
import queue
import secrets
import sys

import zenoh

NAME = sys.argv[1] if len(sys.argv) > 1 else "avoid1"
KEY, JSON, INSTANCE = "iw/v1/main", "application/json;iw.v1", secrets.token_hex(8)
EYES = {"left": 35.0, "front": 0.0, "right": -35.0}
EYE = {"X": 0.6, "Y": 0.0, "Z": 0.4, "ConeDeg": 40.0, "MaxRange": 3.0}
PROXIMITY = [{"Id": eye, "DirectionDeg": angle, **EYE} for eye, angle in EYES.items()]
BODY = {"Length": 1.1, "Width": 0.6, "Center": 0.4, "TopSpeed": 1.0, "Track": 0.57}
ROBOT = {"Kind": "wheelchair", "Instance": INSTANCE, **BODY, "Proximity": PROXIMITY}

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps(sys.argv[2:3] or ["tcp/127.0.0.1:7447"]))
arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
with (
    zenoh.open(config) as session,
    session.declare_subscriber(f"{KEY}/out/{NAME}/measures", arrived.put),
    session.liveliness().declare_token(f"{KEY}/in/{NAME}/alive/both/{INSTANCE}"),
    session.declare_publisher(
        f"{KEY}/in/{NAME}/actions",
        encoding=JSON,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=zenoh.Priority.INTERACTIVE_HIGH,
    ) as actions,
):
    reply = next(iter(session.get(f"{KEY}/join/{NAME}", payload=json.dumps(ROBOT), encoding=JSON)), None)
    answer = None if reply is None else reply.ok or reply.err
    if reply is None or answer is None:
        sys.exit("no simulator there, or not allowed")
    joined = json.loads(answer.payload.to_bytes())
    if reply.ok is None:
        sys.exit(joined["Text"])
    while True:
        measures = json.loads(arrived.get(timeout=30.0).payload.to_bytes())
        # Without a Value the reading is `none`, nothing within 3 m, or `near`, touching.
        readings = {reading["Id"]: reading for reading in measures["Sensors"]["Proximity"]}
        see = {eye: r.get("Value", 0.0 if r.get("Status") == "near" else 3.0) for eye, r in readings.items()}
        free = min(see.values())
        forward = min(0.5, 0.5 * (free - 0.5)) if free > 0.5 else 0.0
        turn = 0.25 * (see["left"] - see["right"]) if free > 0.5 else 0.3
        powers = {"LeftMotor": forward - turn, "RightMotor": forward + turn}
        said = {"Run": measures["Run"], "Session": joined["Session"], "Tick": measures["Tick"], "Seq": measures["Tick"]}
        actions.put(json.dumps(said | {name: min(max(power, -1.0), 1.0) for name, power in powers.items()}))
