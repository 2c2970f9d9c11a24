"""A program by somebody who uses no harness of this project and does not expect a second run.

It joins once, drives straight on, and answers measures of the run in which it joined.
"""

from __future__ import annotations

from pathlib import Path

PROGRAM = """\
import json, queue, secrets, sys, time

import zenoh

name, endpoint, world = sys.argv[1:]
KEY, JSON, INSTANCE = f"iw/v1/{world}", "application/json;iw.v1", secrets.token_hex(8)
ROBOT = {"Kind": "wheelchair", "Instance": INSTANCE, "Length": 1.1, "Width": 0.6, "Center": 0.4, "TopSpeed": 1.0,
         "Track": 0.57, "MotorNoise": 0.1}
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([endpoint]))
arrived = queue.SimpleQueue()
with zenoh.open(config) as session:
    subscriber = session.declare_subscriber(f"{KEY}/out/{name}/measures", arrived.put)
    token = session.liveliness().declare_token(f"{KEY}/in/{name}/alive/both/{INSTANCE}")
    while True:
        (reply,) = session.get(f"{KEY}/join/{name}", payload=json.dumps(ROBOT), encoding=JSON)
        if reply.ok is not None:
            break
        refused = json.loads(reply.err.payload.to_bytes())
        if refused["Code"] != "no-token":
            sys.exit(refused["Text"])
        time.sleep(0.1)
    joined = json.loads(reply.ok.payload.to_bytes())
    while True:
        measures = json.loads(arrived.get().payload.to_bytes())
        if measures["Run"] == joined["Run"]:
            answer = {"Run": measures["Run"], "Session": joined["Session"], "Tick": measures["Tick"],
                      "Seq": measures["Tick"], "LeftMotor": 0.5, "RightMotor": 0.5}
            session.put(f"{KEY}/in/{name}/actions", json.dumps(answer), encoding=JSON)
"""

COMMAND = "python foreign.py {name} {endpoint} {world}"


def write_foreign(folder: Path) -> Path:
    """Write the program to a folder and return its path."""
    path = folder / "foreign.py"
    path.write_text(PROGRAM)
    return path
