"""A run that never was, with something of everything a panel can show."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

from intellwheels_maps import library
from intellwheels_schemas.agent_colours import looks
from intellwheels_schemas.messages import (
    Body,
    BumperReading,
    Clock,
    CompassReading,
    EncodersReading,
    Entity,
    Event,
    Goal,
    GPSReading,
    GroundReading,
    Identity,
    IMUReading,
    LidarReading,
    May,
    Measures,
    OdometryReading,
    Proximity,
    ProximityReading,
    Robot,
    Sensors,
)
from intellwheels_viewer.page_rights import PageRights
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.snapshot import Sample, Snapshot, Utterance

LOOKS_ONLY = PageRights("guests may only look")
DENIED = PageRights(holders=(Identity(name="guest", may=(May(role="viewer", agents=("chair2",)),)),))
"""Of a user who may drive one chair."""
RUN = "9f3c21d4a0b1c2d3"
PERIOD = 0.05
TICK = 1687
NOW = TICK * PERIOD
CHAIRS = ("chair1", "chair2", "chair3", "chair4", "chair5", "chair6", "iris-of-the-east-wing-room-12b")
LASER = LidarReading(
    id="laser", tick=TICK - 2, start_deg=-90.0, step_deg=90.0, ranges=(1.0, None, 2.5), statuses=("ok", "none", "ok")
)
THANKS = (Utterance("chair1", 83.2, "<b>thanks</b>"),)
SENSORS = ("front", "left", "right", "rear", "front-left", "front-right")


def robot(name: str) -> Robot:
    base = library.robot("intellwheels")
    wedges = tuple(
        Proximity(id=sensor, x=0.5, y=0.0, z=0.4, direction_deg=60.0 * k, cone_deg=30.0, min_range=0.05, max_range=3.0)
        for k, sensor in enumerate(SENSORS)
    )
    return replace_record(base, name=name, proximity=wedges, type="real" if name == "chair2" else "simulated")


def replace_record(record: Robot, **changes: object) -> Robot:
    import msgspec

    return msgspec.structs.replace(record, **changes)


@cache
def snapshot() -> Snapshot:
    floor = library.floor("ward")
    xs = [corner.x for wall in floor.wall for corner in wall.corner]
    ys = [corner.y for wall in floor.wall for corner in wall.corner]
    west, south, across, up = min(xs), min(ys), max(xs) - min(xs), max(ys) - min(ys)
    entities, bodies, history = [], {}, {}
    for k, name in enumerate(CHAIRS):
        x, y, heading = west + across * (0.12 + 0.12 * k), south + up * (0.3 + 0.35 * (k % 2)), 0.7 * k - 1.5
        entities.append(
            Entity(
                name=name,
                x=x,
                y=y,
                heading=math.remainder(heading, math.tau),
                speed=(0.16, 0.72, 0.0, -0.08)[k % 4],
                turn_rate=0.31 - 0.2 * k,
                contacts=(1, 0, 12, 0)[k % 4],
                contact=k == 2,
                state="stale" if k == 1 else "taken" if k == 4 else "drive",
                mode=("avoid", "follow-wall", None)[k % 3],
                goal=Goal(x=3.25, y=1.5) if k == 0 else None,
            )
        )
        bodies[name] = Body(run=RUN, tick=0, owner="5f0c2a9be1d84377", roles=("both",), robot=robot(name))
        history[name] = tuple(sample(k, x, y, heading, second / 20) for second in range(601))
    table = library.robot("table")
    entities.append(Entity(name="table1", x=west + across * 0.8, y=south + up * 0.75, heading=0.4))
    bodies["table1"] = Body(run=RUN, tick=0, robot=replace_record(table, name="table1"))
    return Snapshot(
        phase="live", world="main", worlds=("lab", "main"), endpoint="tcp/127.0.0.1:7447", run=RUN, tick=TICK, time=NOW,
        clock=clock("running"), floor=floor, revision=1, bodies=bodies, entities=tuple(entities), events=events(),
        measures={"chair1": measures()}, history=history,
        utterances=(Utterance("chair1", 80.1, "coming through"), Utterance("chair3", 81.0, "sorry"), *THANKS),
    )  # fmt: skip


def sample(k: int, x: float, y: float, heading: float, second: float) -> Sample:
    back = 0.12 * (30.0 - second)
    time = NOW - 30.0 + second
    ranges = tuple(
        None
        if k == 0 and index == 3 and second > 18
        else 1.4 + 1.2 * math.sin(0.23 * second * (index + 2) / 3 + index + k)
        for index in range(len(SENSORS))
    )
    speed = 0.16 if second > 24 else 0.75 * math.sin(second / 6.0)
    at = (x - back * math.cos(heading), y - back * math.sin(heading) + 0.3 * math.sin(second / 3) * back / 3.6)
    return Sample(time, at[0], at[1], heading, speed, ranges)


def clock(state: str, **changes: object) -> Clock:
    fields: dict[str, object] = {
        "run": RUN, "tick": TICK, "time": NOW, "state": state, "pace": "realtime", "speed": 1.0,
        "factor": 0.998 if state == "running" else 0.0, "late": 3, "hash": "00000000000000ff", "stamp": 1.8e9,
    }  # fmt: skip
    return Clock(**{**fields, **changes})  # type: ignore[arg-type]


def measures() -> Measures:
    ranges = sample(0, 0.0, 0.0, 0.0, 30.0).ranges
    proximity = [
        ProximityReading(id=sensor, value=value, status="ok" if value is not None else "none")
        for sensor, value in zip(SENSORS, ranges, strict=True)
    ]
    proximity[4] = ProximityReading(id=SENSORS[4], status="fault")
    return Measures(
        run=RUN, tick=TICK, time=NOW,
        sensors=Sensors(
            proximity=tuple(proximity),
            lidar=(LASER,),
            encoders=(EncodersReading(id="wheels", left=120034, right=-3),),
            odometry=(OdometryReading(id="odometry", x=1.25, y=-0.5, heading=1.57),),
            compass=(CompassReading(id="compass", value=-0.5),),
            gps=(GPSReading(id="gps", status="none"),),
            imu=(IMUReading(id="imu", forward=0.12, left=-0.03, turn_rate=0.31),),
            ground=(GroundReading(id="ground", zone="ward1"),),
            bumper=(BumperReading(id="bumper", value=True),),
        ),
    )  # fmt: skip


def events() -> tuple[Event, ...]:
    def event(number: int, tick: int, code: str, **changes: object) -> Event:
        return Event(run=RUN, tick=tick, number=number, code=code, **changes)  # type: ignore[arg-type]

    return (
        Event(run="0000000000000001", tick=9000, number=0, code="reset"),
        *(event(k, 0, "joined", agent=name) for k, name in enumerate(CHAIRS)),
        event(7, 0, "resumed"),
        event(8, 412, "contact", agent="chair3", other="wall", speed=0.42, x=1.0, y=1.0),
        event(9, 431, "parted", agent="chair3", other="wall"),
        event(10, 900, "contact", agent="chair1", other="chair3", speed=0.11),
        event(11, 1203, "spawned", agent="table1"),
        event(12, 1300, "taken", agent="chair5"),
        event(13, 1601, "stale", agent="chair2"),
    )


def choices() -> Choices:
    return Choices(selected="chair1", looks=looks(CHAIRS))


def nothing(phase: str, **changes: object) -> Snapshot:
    """A page without a run."""
    return replace(Snapshot(phase=phase, endpoint="tcp/127.0.0.1:7447"), **changes)  # type: ignore[arg-type]


ATTACK = '<img src=x: onerror="window.hacked=1">\'`&'


def hostile() -> Snapshot:
    """A run all of whose texts are an attack, as if the wire's own patterns did not hold."""
    from intellwheels_schemas.messages import Map

    base = snapshot()
    entity = Entity(name=ATTACK, x=1.0, y=1.0, heading=0.0, mode=ATTACK, say=ATTACK, contact=True)
    body = replace_record(robot("chair2"), name=ATTACK, kind=ATTACK)
    reading = Sensors(proximity=(ProximityReading(id=ATTACK, value=0.5),), ground=(GroundReading(id="g", zone=ATTACK),))
    return replace(
        base,
        world=ATTACK,
        worlds=(ATTACK, "main"),
        endpoint=ATTACK,
        clock=clock("waiting", waiting=(ATTACK,)),
        floor=Map(format="iw.v1", name=ATTACK, title=ATTACK),
        entities=(entity,),
        bodies={ATTACK: Body(run=RUN, tick=0, robot=body)},
        events=(Event(run=RUN, tick=1, number=1, code="contact", agent=ATTACK, other=ATTACK, text=ATTACK),),
        utterances=(Utterance(ATTACK, 1.0, ATTACK),),
        measures={ATTACK: Measures(run=RUN, tick=1, time=0.05, sensors=reading)},
        history={ATTACK: base.history["chair1"]},
    )


def attacked() -> Choices:
    return Choices(selected=ATTACK, looks=looks([ATTACK]), placing=ATTACK)
