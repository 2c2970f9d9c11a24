"""Lesson 8: an agent without the harness, as you would write it in any language with a Zenoh library.

Run each command in a terminal of its own:

    iw-server --map room
    python 08_another_language.py

To let it play a chair of a scene:

    iw-run figure6 --view --command chair1="python 08_another_language.py {endpoint}"

The chair drives, and turns where something is near. The agent uses Zenoh and JSON only. `schemas/KEYS.md` describes
every key and field. The folder `other_languages` has complete agents, which also survive a restart of the simulator.
"""

import json
import queue
import secrets
import sys

import zenoh

KEY, JSON = "iw/v1/main", "application/json"
INSTANCE = secrets.token_hex(8)  # new in each process
EYE = {"Id": "front", "X": 0.6, "Y": 0.0, "Z": 0.4, "DirectionDeg": 0.0, "ConeDeg": 40.0, "MaxRange": 3.0}
BODY = {"Length": 1.1, "Width": 0.6, "Center": 0.4, "TopSpeed": 1.0, "Track": 0.57}
ROBOT = {"Kind": "wheelchair", "Instance": INSTANCE, **BODY, "Proximity": [EYE]}

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps(sys.argv[1:] or ["tcp/127.0.0.1:7447"]))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    sys.exit("no simulator answers; start it first")
with session:
    arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
    session.declare_subscriber(f"{KEY}/out/chair1/measures", arrived.put)
    # The token tells the simulator that this process runs. It disappears with the process.
    token = session.liveliness().declare_token(f"{KEY}/in/chair1/alive/both/{INSTANCE}")
    (reply,) = session.get(f"{KEY}/join/chair1", payload=json.dumps(ROBOT), encoding=JSON)
    if reply.ok is None:
        sys.exit(reply.err.payload.to_string() if reply.err else "no answer")
    joined = json.loads(reply.ok.payload.to_bytes())
    while True:
        measures = json.loads(arrived.get().payload.to_bytes())
        (front,) = measures["Sensors"]["Proximity"]
        # Without a value there is nothing within the range of the sensor, or something too near to measure.
        free = front.get("Value", 0.0 if front.get("Status") == "near" else 3.0)
        left, right = (0.4, 0.4) if free > 1.0 else (-0.2, 0.2)
        answer = {
            "Run": measures["Run"], "Session": joined["Session"], "Tick": measures["Tick"], "Seq": measures["Tick"],
            "LeftMotor": left, "RightMotor": right,
        }  # fmt: skip
        session.put(f"{KEY}/in/chair1/actions", json.dumps(answer), encoding=JSON)
