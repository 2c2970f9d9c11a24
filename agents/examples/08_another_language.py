"""Lesson 8: an agent without the harness, as you would write it in any language with a Zenoh library.

The chair drives, and turns where something is near. Run each command in a terminal of its own:

    iw-server --map room
    python 08_another_language.py

To let it play a chair of a scene, and to check that it meets the contract (`schemas/KEYS.md`):

    iw-run figure6 --view --command chair1="python 08_another_language.py {endpoint}"
    iw-check-agent -- python 08_another_language.py {endpoint}
"""

import json
import queue
import secrets
import sys
import time

import zenoh

KEY, JSON = "iw/v1/main", "application/json"
INSTANCE = secrets.token_hex(8)  # new in each process
EYE = {"Id": "front", "X": 0.6, "Y": 0.0, "Z": 0.4, "DirectionDeg": 0.0, "ConeDeg": 40.0, "MaxRange": 3.0}
BODY = {"Length": 1.1, "Width": 0.6, "Center": 0.4, "TopSpeed": 1.0, "Track": 0.57}
ROBOT = {"Kind": "wheelchair", "Instance": INSTANCE, **BODY, "Proximity": [EYE]}
CONFIG = {"mode": "client", "connect": {"endpoints": sys.argv[1:] or ["tcp/127.0.0.1:7447"]}}
try:
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(CONFIG)))
except zenoh.ZError:
    sys.exit("no simulator answers; start it first")
with session:
    arrived: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
    session.declare_subscriber(f"{KEY}/out/chair1/measures", arrived.put)
    # The token tells the simulator that this process runs. It disappears with the process. The simulator has one too.
    token = session.liveliness().declare_token(f"{KEY}/in/chair1/alive/both/{INSTANCE}")
    session.liveliness().declare_subscriber(f"{KEY}/alive", arrived.put, history=True)
    ours, run, tick = "", "", 0
    while True:
        sample = arrived.get()
        if str(sample.key_expr) == f"{KEY}/alive":  # the simulator started, perhaps again, or ended
            ours = ""
            while sample.kind == zenoh.SampleKind.PUT and not ours:
                for reply in session.get(f"{KEY}/join/chair1", payload=json.dumps(ROBOT), encoding=JSON):
                    if reply.err and "no-token" not in reply.err.payload.to_string():
                        sys.exit(reply.err.payload.to_string())
                    ours = json.loads(reply.ok.payload.to_bytes())["Session"] if reply.ok else ""
                time.sleep(0.1)  # no-token: the simulator does not know our token yet, so we ask again
            continue
        measures = json.loads(sample.payload.to_bytes())
        if not ours or (measures["Run"] == run and measures["Tick"] < tick):
            continue  # measures that were late
        run, tick = measures["Run"], measures["Tick"]
        (front,) = measures["Sensors"]["Proximity"]
        # Without a value there is nothing within the range of the sensor, or something too near to measure.
        free = front.get("Value", 0.0 if front.get("Status") == "near" else 3.0)
        left, right = (0.4, 0.4) if free > 1.0 else (-0.2, 0.2)
        answer = {"Run": run, "Session": ours, "Tick": tick, "Seq": tick, "LeftMotor": left, "RightMotor": right}
        session.put(f"{KEY}/in/chair1/actions", json.dumps(answer), encoding=JSON)
