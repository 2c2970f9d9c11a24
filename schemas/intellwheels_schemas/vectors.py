"""Test vectors for all implementations: messages with their exact bytes, and documents that must be refused.

`generate` writes them to `schemas/vectors/`, and a test compares the two.
"""

from __future__ import annotations

import re
from typing import Any, Final, NamedTuple, TypeVar

import msgspec

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import (
    GPS,
    IMU,
    ROOTS,
    Actions,
    AgentActions,
    AgentJoined,
    AgentLeave,
    AgentMeasures,
    AgentRefused,
    Beacon,
    BeaconReading,
    Body,
    Bridge,
    Bumper,
    BumperReading,
    Cast,
    Clock,
    Compare,
    Compass,
    CompassReading,
    Corner,
    CrewActions,
    CrewError,
    CrewJoin,
    CrewJoined,
    CrewLeave,
    CrewMeasures,
    Delete,
    Door,
    Doorway,
    Encoders,
    EncodersReading,
    End,
    Entity,
    Error,
    Event,
    Events,
    Experiment,
    Goal,
    GPSReading,
    Grid,
    Ground,
    GroundReading,
    Heard,
    Hold,
    Identity,
    IMUReading,
    Joined,
    Lab,
    Leave,
    Level,
    Lidar,
    LidarReading,
    Load,
    Map,
    MapInfo,
    May,
    Measures,
    Obstacle,
    Odometry,
    OdometryReading,
    OperatorSay,
    Option,
    Parameters,
    Part,
    Pause,
    Place,
    Pose,
    Position,
    PowerInForce,
    Proximity,
    ProximityReading,
    Quit,
    Reach,
    Record,
    Refused,
    Reset,
    Restore,
    Result,
    Resume,
    Robot,
    Route,
    Save,
    Say,
    Scene,
    Seek,
    Sensors,
    Setting,
    SiteOffset,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
    Timeout,
    Truth,
    TruthReading,
    Umbmark,
    Uniform,
    UserInput,
    Varied,
    Wall,
    WorldState,
    Zone,
)
from intellwheels_schemas.metal_codes import code_of, pose_line, power_line

NAMES: Final[dict[str, type[Record]]] = {
    ("OperatorSay" if cls is OperatorSay else root): cls for cls, root in ROOTS.items()
}
"""The documents by the name of the XML root; `OperatorSay` has its own name, because its root is also `Say`."""

RUN: Final = "9f3c21d4a0b1c2d3"
SESSION: Final = "c0ffee0012345678"
INSTANCE: Final = "5f0c2a9be1d84377"
KEY: Final = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f"
HASH: Final = "00d1ce0ff1ce0ff1"

CHAIR: Final = Robot(
    name="chair1",
    kind="wheelchair",
    instance=INSTANCE,
    place="bed1",
    top_speed=1.0,
    acceleration_curve=0.5,
    track=0.572,
    wheel_diameter=0.368,
    part=(
        Part(x=0.25, y=0.0, length=1.2, width=0.66, bottom=0.0, top=0.5),
        Part(x=0.0, y=0.0, length=0.7, width=0.6, bottom=0.5, top=1.3),
    ),
    proximity=(
        Proximity(
            id="front", x=0.8, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, min_range=0.05, max_range=4.0
        ),
    ),
    encoders=(Encoders(id="wheels"),),
)  # fmt: skip

EVERY_SENSOR: Final = Robot(
    name="lab-1",
    type="real",
    kind="wheelchair",
    role="body",
    instance=INSTANCE,
    barrier=False,
    crew="crew1",
    user_input=("drive", "words", "goal"),
    hardware="simulated",
    top_speed=1.5,
    acceleration_curve=0.25,
    track=0.5,
    wheel_diameter=0.3,
    encoder_ticks=1000,
    command_timeout=0.25,
    anchored=True,
    acceleration_limit=2.0,
    turn_limit=1.5,
    motor_noise=0.015,
    slip=0.1,
    length=1.1,
    width=0.62,
    center=0.25,
    top=1.2,
    position=Position(x=1.0, y=2.0, heading=1.5),
    proximity=(
        Proximity(
            id="sonar", x=0.5, y=-0.25, z=0.4, direction_deg=-45.0, cone_deg=25.0, max_range=3.0, model="sonar",
            every=2, latency=3, source="real",
        ),
    ),
    lidar=(
        Lidar(
            id="lidar", x=0.4, y=0.0, z=0.3, direction_deg=0.0, fov_deg=270.0, rays=1080, min_range=0.02,
            max_range=30.0, noise=0.01, noise_share=0.001,
        ),
    ),
    encoders=(Encoders(id="wheels", source="real"),),
    odometry=(Odometry(id="odometry"),),
    compass=(Compass(id="compass", noise_deg=0.5, step_deg=1.0),),
    gps=(GPS(id="gps", x=0.1, y=0.2, noise=0.5),),
    imu=(IMU(id="imu", noise=0.02, turn_noise=0.001),),
    beacon=(Beacon(id="door1", place="d1", z=1.0, direction_deg=90.0, cone_deg=120.0, max_range=8.0, noise_deg=2.0),),
    ground=(Ground(id="ground", x=0.3),),
    bumper=(Bumper(id="bumper"),),
    truth=(Truth(id="truth"),),
)  # fmt: skip

ERRING: Final = Robot(
    name="lab-2", kind="wheelchair", instance=INSTANCE, top_speed=1.5, length=1.1, width=0.62, wheel_ratio=1.002,
    wheel_scale=0.99, track_ratio=1.01,
    proximity=(
        Proximity(
            id="ir", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=10.0, max_range=1.5, model="infrared",
            noise_volts=0.02, dropout=0.01,
        ),
        Proximity(
            id="sonar", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, model="sonar",
            dropout=0.01, crosstalk=0.5, group=1, every=4,
        ),
    ),
    lidar=(
        Lidar(
            id="lidar", x=0.4, y=0.0, z=0.3, direction_deg=0.0, fov_deg=270.0, rays=271, max_range=8.0,
            incidence_deg=80.0, dropout=0.001,
        ),
    ),
    encoders=(Encoders(id="wheels", drift=0.000001),),
    compass=(Compass(id="compass", walk_deg=0.5),),
    gps=(GPS(id="gps", walk=0.05, step=0.01),),
    imu=(IMU(id="imu", walk=0.01, turn_walk=0.001, step=0.01, turn_step=0.001),),
    beacon=(Beacon(id="bed", place="bed1", walk_deg=0.5, step_deg=1.0),),
)  # fmt: skip

DOOR: Final = Robot(
    format="iw.v1", kind="door", top_speed=0.3, track=0.5, length=1.0, width=0.1, center=0.99, top=2.0,
    proximity=(
        Proximity(
            id="in-left", x=-0.79, y=0.05, z=0.4, direction_deg=90.0, cone_deg=30.0, max_range=6.0, mount="start"
        ),
    ),
)  # fmt: skip

ROOM: Final = Map(
    format="iw.v1",
    name="room",
    title="Figure 6",
    source="paper",
    wall=(
        Wall(height=2.0, corner=(Corner(x=0.0, y=0.0), Corner(x=1.0, y=0.0), Corner(x=1.0, y=1.0))),
        Wall(bottom=0.1, thickness=0.1, corner=(Corner(x=6.0, y=-2.0), Corner(x=6.0, y=-0.5))),
    ),
    doorway=(
        Doorway(name="d1", x=6.0, y=0.0, heading_deg=0.0, width=1.0),
        Doorway(
            name="d2", x=6.0, y=3.0, heading_deg=0.0, width=1.0, door=Door(kind="hinged", side="right", swing_deg=-90.0)
        ),
    ),
    obstacle=(
        Obstacle(name="bed", top=0.6, corner=(Corner(x=2.0, y=2.0), Corner(x=4.0, y=2.0), Corner(x=4.0, y=3.0))),
    ),
    zone=(
        Zone(
            name="w1", title='Ward 1, "east" & <west>',
            corner=(Corner(x=0.0, y=0.0), Corner(x=9.0, y=0.0), Corner(x=9.0, y=9.0)),
        ),
    ),
    grid=Grid(
        position=(
            Place(name="bed1", x=1.0, y=2.0, heading_deg=90.0, kinds=("wheelchair", "person")),
            Place(name="goal1", x=5.0, y=1.0),
        )
    ),
    route=(Route(name="lane1", places=("bed1", "goal1"), one_way=True),),
    offset=SiteOffset(x=489123.0, y=4412345.5, epsg="EPSG:32629"),
)  # fmt: skip

_P = TypeVar("_P", Pose, PowerInForce)


def _coded(message: _P) -> _P:
    line = pose_line(message) if isinstance(message, Pose) else power_line(message)
    return msgspec.structs.replace(message, code=code_of(KEY, line))


_END = End(reach=(Reach(agent="chair1", place="goal1", within=0.3),), timeout=Timeout(seconds=120.0))

_PERCEIVED = Sensors(
    proximity=(
        ProximityReading(id="a", value=1.25),
        ProximityReading(id="b", status="none"),
        ProximityReading(id="c", status="near"),
        ProximityReading(id="d", status="fault"),
    ),
    lidar=(
        LidarReading(
            id="l", tick=40, stamp=2.0, start_deg=-90.0, step_deg=90.0, ranges=(1.0, None, 2.5),
            statuses=("ok", "none", "ok"),
        ),
    ),
    encoders=(EncodersReading(id="wheels", left=1200, right=-3),),
)  # fmt: skip

VALID: Final[dict[str, Record]] = {
    "Robot-chair": CHAIR,
    "Robot-every-sensor": EVERY_SENSOR,
    "Robot-errors": ERRING,
    "Robot-mind": Robot(role="mind", instance=INSTANCE, barrier=True, crew="crew1", user_input=("drive",)),
    "Robot-file": DOOR,
    "Joined": Joined(
        run=RUN,
        tick=12,
        session=SESSION,
        parameters=Parameters(
            world="main", period=0.05, pace="lockstep", say_limit=100, say_range=8.0, command_timeout=0.5, grace=3.0
        ),
        position=Position(x=1.0, y=2.0, heading=0.0),
        robot=CHAIR,
    ),
    "Joined-bridge": Joined(
        run=RUN,
        tick=12,
        session=SESSION,
        parameters=Parameters(
            world="main", period=0.05, pace="realtime", say_limit=100, say_range=8.0, command_timeout=0.5, grace=3.0
        ),
        position=Position(x=1.0, y=2.0, heading=0.0),
        robot=msgspec.structs.replace(CHAIR, type="real", role="body"),
        key=KEY,
    ),
    "Refused": Refused(code="already-here", text="agent 'chair1' is already here"),
    "Leave": Leave(run=RUN, session=SESSION),
    "Actions-say": Actions(
        run=RUN, session=SESSION, tick=41, seq=41, left_motor=0.5, right_motor=0.4, mode="autonomous",
        goal=Goal(x=5.0, y=1.0), say="follow me",
    ),
    "Actions-paper": Actions(session=SESSION, left_motor=0.5, right_motor=0.4, say="follow me"),
    "Actions-answer": Actions(session=SESSION, tick=5),
    "Actions-empty": Actions(session=SESSION),
    "Actions-leave": Actions(session=SESSION, tick=9, leave=True, goal=Goal(x=0.0, y=0.0, heading=-1.5), say=""),
    "Actions-text": Actions(session=SESSION, say="]]> <b>&amp; \"'\n\té 漢 😀 null NaN {\"Tick\":1}"),
    "Actions-floats": Actions(session=SESSION, left_motor=0.00001, right_motor=-1e-7),
    "CrewJoin": CrewJoin(
        crew="crew1", instance=INSTANCE,
        robot=(msgspec.structs.replace(CHAIR, name="a1", instance=None), Robot(name="a2", role="mind")),
    ),
    "CrewJoined": CrewJoined(
        crew="crew1", run=RUN, tick=12,
        parameters=Parameters(
            world="main", period=0.05, pace="lockstep", say_limit=100, say_range=8.0, command_timeout=0.5, grace=3.0
        ),
        joined=(
            AgentJoined(agent="a1", session=SESSION, position=Position(x=1.0, y=2.0, heading=0.0), robot=CHAIR),
        ),
        refused=(AgentRefused(agent="a2", code="no-body", text="agent 'a2' has no body here yet"),),
    ),
    "CrewLeave": CrewLeave(crew="crew1", leave=(AgentLeave(agent="a1", session=SESSION),)),
    "CrewError": CrewError(
        run=RUN, tick=7, code="not-joined", where="CrewActions.Actions[0].Agent", agent="a9",
        text="CrewActions.Actions[0].Agent: expected an agent that joined with crew 'crew1', got 'a9'",
    ),
    "CrewActions": CrewActions(
        crew="crew1", parts=2,
        actions=(AgentActions(agent="a1", session=SESSION, tick=3, left_motor=1.0, right_motor=-1.0),),
    ),
    "CrewMeasures": CrewMeasures(
        crew="crew1", part=1, parts=2,
        measures=(
            AgentMeasures(
                agent="a1", run=RUN, tick=3, time=0.15, contact=True, state="timeout", sensors=_PERCEIVED,
            ),
        ),
    ),
    "Say": Say(run=RUN, session=SESSION, tick=41, seq=2, text="open"),
    "Say-paper": Say(session=SESSION, text="open"),
    "Measures": Measures(
        run=RUN, tick=42, time=2.1, collision=True, sensors=_PERCEIVED,
        message=(Heard(sender="chair2", tick=41, seq=7, distance=3.2, text="here"),),
    ),
    "Measures-first": Measures(run=RUN, tick=0, time=0.0),
    "Measures-taken": Measures(run=RUN, tick=42, time=2.1, contact=True, state="taken"),
    "Measures-every-sensor": Measures(
        run=RUN,
        tick=9007199254740991,
        time=1e9,
        contact=True,
        sensors=Sensors(
            proximity=(ProximityReading(id="sonar", tick=40, value=0.0),),
            lidar=(LidarReading(id="lidar", start_deg=0.0, step_deg=0.25),),
            encoders=(EncodersReading(id="wheels", left=0, right=0),),
            odometry=(OdometryReading(id="odometry", x=1.0, y=-2.0, heading=3.0),),
            compass=(CompassReading(id="compass", value=-0.5),),
            gps=(GPSReading(id="gps", x=1.5, y=2.5), GPSReading(id="gps2", status="fault")),
            imu=(IMUReading(id="imu", forward=0.5, left=-0.25, turn_rate=0.125),),
            beacon=(BeaconReading(id="door1", status="none"),),
            ground=(GroundReading(id="ground", zone="w1"), GroundReading(id="ground2")),
            bumper=(BumperReading(id="bumper", value=False),),
            truth=(TruthReading(id="truth", x=1.0, y=2.0, heading=0.5, speed=0.75, turn_rate=0.0),),
        ),
        user_input=UserInput(forward=0.5, turn=-0.25, buttons=(0, 3)),
    ),
    "Pose": Pose(
        run=RUN, session=SESSION, tick=41, seq=41, x=1.0, y=2.0, heading=0.5, stamp=1700000000.25,
        covariance=(0.01, 0.0, 0.0, 0.02, 0.001, 0.005),
        sensors=Sensors(proximity=(ProximityReading(id="sonar", value=0.75),)),
    ),
    "Pose-coded": _coded(
        Pose(run=RUN, session=SESSION, tick=41, seq=41, x=1.25, y=-2.0, heading=0.1, stamp=1800000000.5)
    ),
    "Pose-bare": Pose(session=SESSION, x=0.0, y=0.0, heading=0.0),
    "Power": PowerInForce(run=RUN, tick=41, left_motor=0.5, right_motor=-0.5),
    "Power-coded": _coded(PowerInForce(run=RUN, tick=41, seq=7, left_motor=0.5, right_motor=-0.25)),
    "Lab": Lab(
        format="iw.v1", name="room3",
        identity=(
            Identity(name="simulator", may=(May(role="simulator"),)),
            Identity(
                name="student1", until="2027-02-28",
                may=(May(role="agent", agents=("st1-*",)), May(role="viewer", agents=("st1-*",))),
            ),
            Identity(name="bridge1", certificate=True, may=(May(role="bridge", agents=("real1",)),)),
            Identity(name="teacher", may=(May(role="operator", agents=("*",), verbs=("pause", "resume", "take")),)),
        ),
    ),
    "Power-paused": PowerInForce(run=RUN, tick=41, left_motor=0.0, right_motor=0.0, state="paused"),
    "UserInput-stick": UserInput(lease=SESSION, seq=3, forward=1.0, turn=-1.0, buttons=(0, 7)),
    "UserInput-word": UserInput(word="left"),
    "UserInput-goal": UserInput(goal=Goal(x=5.0, y=1.0, heading=0.0)),
    "Error": Error(
        run=RUN, tick=42, code="value", where="Actions.LeftMotor", seq=41, suppressed=3,
        text="Actions.LeftMotor: expected a number in [-1, 1], got 'fast'",
    ),
    "WorldState": WorldState(
        run=RUN, tick=42, time=2.1, parts=2,
        entity=(
            Entity(
                name="chair1", x=1.5, y=2.5, heading=-3.0, speed=0.5, turn_rate=-0.25, left_output=0.25,
                right_output=0.75, collision=True, contact=True,
                contacts=2, state="taken", mode="manual", goal=Goal(x=5.0, y=1.0), say="follow me",
                travelled=12.25, turned=3.125,
            ),
            Entity(name="table", x=4.5, y=4.5, heading=0.0),
        ),
    ),
    "Body": Body(run=RUN, tick=12, owner=INSTANCE, roles=("body", "mind"), robot=CHAIR),
    "Event-contact": Event(
        run=RUN, tick=42, number=7, code="contact", agent="chair1", other="wall", part=1, other_part=0, x=1.0, y=2.0,
        normal_x=0.0, normal_y=-1.0, speed=0.5,
    ),
    "Event-ended": Event(run=RUN, tick=99, number=8, code="ended", text="everybody is there"),
    "Events": Events(run=RUN, oldest=7, next=8, event=(Event(run=RUN, tick=1, number=7, code="joined", agent="a"),)),
    "Clock": Clock(
        run=RUN, tick=42, time=2.1, state="waiting", pace="realtime", speed=2.0, factor=1.98, late=1, hash=HASH,
        load=0.25, world=0.1, wire=0.15, rays=5760, costliest="chair1", flooding="door",
        stamp=1700000000.0, waiting=("chair1", "door"),
    ),
    "Clock-played": Clock(
        run=RUN, tick=42, time=2.1, state="paused", pace="realtime", hash=HASH, stamp=1700000000.0, last=2400,
    ),
    "MapInfo": MapInfo(run=RUN, tick=0, name="room", revision=1, hash=HASH),
    "Map": ROOM,
    "Scene": Scene(
        format="iw.v1",
        name="figure6",
        title="Three chairs, a table and a door",
        map="room",
        cast=(
            Cast(
                name="chair1", robot="rear-wheel", mind="waypoints", place="bed1",
                option=(Option(name="points", value="2 3 4 5"),),
            ),
        ),
        end=_END,
        hold=Hold(contacts=0, reached="all"),
    ),
    "Scene-options": Scene(
        format="iw.v1", name="other", map="floors/own.xml", seed="a b", period=0.1, pace="realtime", miss="elastic",
        truth=True, say_range=4.0, say_walls=True, say_loss=0.1, say_delay=0.2,
        cast=(
            Cast(name="a", robot="r", mind="m"),
            Cast(name="b", place="p", command="./mine {name} {endpoint}", folder="own", new_run="restart"),
        ),
        bridge=(Bridge(agent="a", option=(Option(name="pose", value="raw"),)),),
    ),
    "Scene-experiment": Scene(
        format="iw.v1", name="e", map="room", cast=(Cast(name="a", robot="r", mind="m"),),
        experiment=Experiment(
            subject="a", margin=0.1,
            factor=(
                Varied(
                    name="mode", title="Mode",
                    level=(
                        Level(name="x", title="X", real=True,
                              bridge=(Bridge(agent="a", chair="c", option=(Option(name="pose", value="raw"),)),),
                              setting=(Setting(agent="a", name="speed", value="1"),)),
                        Level(name="y", cast=(Cast(name="a", robot="r", mind="n"),),
                              setting=(Setting(name="SayRange", value="4"),),
                              uniform=(Uniform(agent="a", name="speed", low=-0.1, high=0.1, follows="top"),)),
                    ),
                ),
            ),
            compare=(Compare(first="x", second="y", expect="worse"),),
            uniform=(
                Uniform(place="start", name="HeadingDeg", low=-2.0, high=2.0),
                Uniform(obstacle="bed", name="X", low=-0.1, high=0.1),
            ),
            umbmark=Umbmark(left="x", right="y", side=4.0),
        ),
    ),
    "Result": Result(code="ok", run=RUN, tick=42, hash=HASH, lease=SESSION, slot="s1"),
    "Result-failed": Result(code="not-found", text="no agent 'x'"),
    "Pause": Pause(),
    "Resume": Resume(),
    "Step": Step(count=20),
    "Reset": Reset(seed="7", end=_END),
    "Load-name": Load(name="ward", seed="1"),
    "Load-map": Load(map=ROOM),
    "Speed": Speed(factor=0.5),
    "Spawn": Spawn(
        robot=Robot(name="crate1", kind="crate", length=0.5, width=0.5, top=0.5),
        position=Position(x=1.0, y=1.0, heading=0.0),
    ),
    "Delete": Delete(agent="crate1"),
    "Teleport": Teleport(agent="chair1", position=Position(x=1.0, y=1.0, heading=3.0)),
    "Take": Take(agent="chair1", lease=SESSION, seconds=0.0),
    "OperatorSay": OperatorSay(to="door", text="open"),
    "OperatorSay-all": OperatorSay(text="stop"),
    "Save": Save(),
    "Restore": Restore(slot="s1"),
    "Seek": Seek(tick=100),
    "Seek-run": Seek(tick=100, run=RUN),
    "Quit": Quit(),
}  # fmt: skip
"""All messages by file name, some in several forms."""


class Grown(NamedTuple):
    """A document with unknown fields: other programs read it as the vector `same`, and the simulator refuses it."""

    name: str
    data: str
    same: str


GROWN: Final = (
    Grown(
        "Measures-first.json",
        f'{{"Run":"{RUN}","Tick":0,"Time":0.0,"Weather":{{"Rain":null}},"Mood":[1,"two"]}}',
        "Measures-first",
    ),
    Grown(
        "Measures-first.xml",
        f'<Measures Run="{RUN}" Tick="0" Time="0.0" Mood="1"><Weather Rain="0.0">text</Weather></Measures>',
        "Measures-first",
    ),
    Grown("Refused.json", '{"Code":"already-here","Text":"agent \'chair1\' is already here","Retry":1}', "Refused"),
    Grown(
        "Refused.xml",
        '<Refused Code="already-here" Retry="1"><![CDATA[agent \'chair1\' is already here]]></Refused>',
        "Refused",
    ),
)


class Wrong(NamedTuple):
    """A document that must be refused.

    Attributes:
        name: File name: class, error, encoding.
        data: The bytes.
        code: Code of the error.
        where: Place in the error.
    """

    name: str
    data: bytes
    code: str
    where: str


def _proximity(**changes: str) -> str:
    fields = {
        "Id": "a", "X": "0.0", "Y": "0.0", "Z": "0.4", "DirectionDeg": "0.0", "ConeDeg": "30.0", "MaxRange": "4.0",
        **changes,
    }  # fmt: skip
    return "<Proximity " + " ".join(f'{name}="{value}"' for name, value in fields.items() if value) + "/>"


def _robot(inside: str = "", attributes: str = 'Length="1.0" Width="0.5"') -> bytes:
    return f"<Robot {attributes}>{inside}</Robot>".encode()


def _measures(sensors: str) -> bytes:
    return f'{{"Run":"{RUN}","Tick":1,"Time":0.05,"Sensors":{sensors}}}'.encode()


def _map(inside: str, attributes: str = 'Format="iw.v1" Name="m"') -> bytes:
    return f"<Map {attributes}>{inside}</Map>".encode()


def _experiment(inside: str) -> bytes:
    scene = '<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Robot="r" Mind="m"/><Experiment Subject="a">'
    return f"{scene}{inside}</Experiment></Scene>".encode()


def _lab(inside: str) -> bytes:
    return f'<Lab Format="iw.v1" Name="l">{inside}</Lab>'.encode()


_VIEWER = '<Identity Name="a"><May Role="viewer"/></Identity>'
_CORNER = '<Corner X="0.0" Y="0.0"/>'
_SESSION = SESSION.encode()
_CREW_MEMBER = b'{"Agent":"a","Session":"%s"}' % SESSION.encode()

_REFUSED: Final = (
    # Bytes that are not a document.
    Wrong("Actions-nothing.json", b"", "malformed", "Actions"),
    Wrong("Actions-nothing.xml", b"", "malformed", "Actions"),
    Wrong("Actions-cut.json", b'{"Tick":1,"LeftMotor":0.', "malformed", "Actions"),
    Wrong("Actions-cut.xml", b'<Actions Tick="1"><Say>', "malformed", "Actions"),
    Wrong("Actions-behind.json", b'{"Tick":1}{"Tick":2}', "malformed", "Actions"),
    Wrong("Actions-behind.xml", b'<Actions Tick="1"/><Actions Tick="2"/>', "malformed", "Actions"),
    Wrong("Actions-latin-1.json", b'{"Say":"caf\xe9"}', "malformed", "Actions"),
    Wrong("Actions-latin-1.xml", b"<Actions><Say>caf\xe9</Say></Actions>", "malformed", "Actions"),
    Wrong("Actions-nan.json", b'{"LeftMotor":NaN}', "malformed", "Actions"),
    Wrong("Actions-infinity.json", b'{"LeftMotor":-Infinity}', "malformed", "Actions"),
    Wrong("Actions-twice.json", b'{"Tick":1,"Tick" :2}', "malformed", "Actions"),
    Wrong("Actions-twice-escaped.json", b'{"Tick":1,"Say":"\\u003a","T\\u0069ck":2}', "malformed", "Actions"),
    Wrong("Actions-twice.xml", b'<Actions Tick="1" Tick="2"/>', "malformed", "Actions"),
    Wrong("Actions-goal-twice.json", b'{"Goal":{"X":1.0,"Y":2.0,"X":3.0}}', "malformed", "Actions.Goal"),
    Wrong("Actions-say-twice.xml", b"<Actions><Say>a</Say><Say>b</Say></Actions>", "malformed", "Actions"),
    Wrong("Actions-another-root.xml", b'<Action Tick="1"/>', "malformed", "Actions"),
    Wrong("Actions-namespace.xml", b'<Actions xmlns="urn:x" Tick="1"/>', "malformed", "Actions"),
    Wrong("Actions-deep.json", b"[" * 4000, "malformed", "Actions"),
    Wrong("Actions-document-type.xml", b"<!DOCTYPE Actions><Actions/>", "malformed", "Actions"),
    Wrong(
        "Actions-entities.xml",
        b'<?xml version="1.0"?><!-- x --><!DOCTYPE a [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'
        b"<Actions><Say>&b;</Say></Actions>",
        "malformed",
        "Actions",
    ),
    Wrong("Actions-entity.xml", b"<Actions><Say>&a;</Say></Actions>", "malformed", "Actions"),
    Wrong("Actions-control.xml", b"<Actions><Say>a&#1;b</Say></Actions>", "malformed", "Actions"),
    # Values of another type.
    Wrong("Actions-list.json", b"[1]", "value", "Actions"),
    Wrong("Actions-null.json", b"null", "value", "Actions"),
    Wrong("Actions-say-null.json", b'{"Say":null}', "value", "Actions.Say"),
    Wrong("Actions-goal-null.json", b'{"Goal":null}', "value", "Actions.Goal"),
    Wrong("Actions-goal-number.json", b'{"Goal":5}', "value", "Actions.Goal"),
    Wrong("Actions-left-motor-word.json", b'{"LeftMotor":"fast"}', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-word.xml", b'<Actions LeftMotor="fast"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-text.json", b'{"LeftMotor":"0.5"}', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-nan.xml", b'<Actions LeftMotor="NaN"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-inf.xml", b'<Actions LeftMotor="INF"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-null.xml", b'<Actions LeftMotor="null"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-plus.xml", b'<Actions LeftMotor="+0.5"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-bare.xml", b'<Actions LeftMotor=".5"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-empty.xml", b'<Actions LeftMotor=""/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-high.json", b'{"LeftMotor":1.0001}', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-huge.json", b'{"LeftMotor":1e999}', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-huge.xml", b'<Actions LeftMotor="1e999"/>', "value", "Actions.LeftMotor"),
    Wrong("Actions-left-motor-true.json", b'{"LeftMotor":true}', "value", "Actions.LeftMotor"),
    Wrong("Actions-tick-float.json", b'{"Tick":5.0}', "value", "Actions.Tick"),
    Wrong("Actions-tick-exponent.json", b'{"Tick":1e3}', "value", "Actions.Tick"),
    Wrong("Actions-tick-exponent.xml", b'<Actions Tick="1e3"/>', "value", "Actions.Tick"),
    Wrong("Actions-tick-space.xml", b'<Actions Tick=" 5"/>', "value", "Actions.Tick"),
    Wrong("Actions-tick-zeros.xml", b'<Actions Tick="007"/>', "value", "Actions.Tick"),
    Wrong("Actions-tick-negative.json", b'{"Tick":-1}', "value", "Actions.Tick"),
    Wrong("Actions-tick-high.json", b'{"Tick":9007199254740992}', "value", "Actions.Tick"),
    Wrong("Actions-leave-number.json", b'{"Leave":1}', "value", "Actions.Leave"),
    Wrong("Actions-leave-capital.xml", b'<Actions Leave="True"/>', "value", "Actions.Leave"),
    Wrong("Actions-run-capital.json", b'{"Run":"9F3C21D4A0B1C2D3"}', "value", "Actions.Run"),
    Wrong("Actions-run-number.json", b'{"Run":1234567890123456}', "value", "Actions.Run"),
    Wrong("Actions-mode-space.xml", b'<Actions Mode="by hand"/>', "value", "Actions.Mode"),
    Wrong("Actions-say-control.json", b'{"Say":"a\\u0001b"}', "value", "Actions.Say"),
    Wrong("Actions-say-return.json", b'{"Say":"a\\rb"}', "value", "Actions.Say"),
    Wrong("Actions-say-return.xml", b"<Actions><Say>a&#13;b</Say></Actions>", "value", "Actions.Say"),
    Wrong("Actions-say-surrogate.json", b'{"Say":"\\ud800"}', "value", "Actions.Say"),
    Wrong("Actions-say-noncharacter.json", b'{"Say":"\\uffff"}', "value", "Actions.Say"),
    # Fields.
    Wrong("Actions-unknown.json", b'{"LeftMoter":0.5}', "field", "Actions.LeftMoter"),
    Wrong("Actions-unknown.xml", b'<Actions LeftMoter="0.5"/>', "field", "Actions.LeftMoter"),
    Wrong("Actions-python-name.json", b'{"left_motor":0.5}', "field", "Actions.left_motor"),
    Wrong("Actions-unknown-element.xml", b"<Actions><Shout>hi</Shout></Actions>", "field", "Actions.Shout"),
    Wrong("Actions-say-attribute.xml", b'<Actions Say="hi"/>', "field", "Actions.Say"),
    Wrong("Actions-say-child.xml", b"<Actions><Say><b>hi</b></Say></Actions>", "field", "Actions.Say"),
    Wrong("Actions-stray-text.xml", b"<Actions>hello</Actions>", "field", "Actions"),
    Wrong("Actions-goal-half.json", b'{"Goal":{"X":5.0}}', "field", "Actions.Goal.Y"),
    Wrong("Actions-goal-half.xml", b'<Actions><Goal X="5.0"/></Actions>', "field", "Actions.Goal.Y"),
    Wrong("Actions-no-session.json", b'{"Tick":1}', "field", "Actions.Session"),
    Wrong("Actions-no-session.xml", b'<Actions Tick="1"/>', "field", "Actions.Session"),
    Wrong("Say-no-session.xml", b"<Say><![CDATA[hi]]></Say>", "field", "Say.Session"),
    Wrong("Pose-no-session.json", b'{"X":0.0,"Y":0.0,"Heading":0.0}', "field", "Pose.Session"),
    Wrong("Leave-no-session.json", b"{}", "field", "Leave.Session"),
    Wrong("Leave-no-session.xml", b"<Leave/>", "field", "Leave.Session"),
    Wrong("Lab-identity-twice.xml", _lab(f'{_VIEWER}{_VIEWER}'), "value", "Lab.Identity[1].Name"),
    Wrong("Lab-until-no-day.xml", _lab('<Identity Name="a" Until="2027-02-30"/>'), "value", "Lab.Identity[0].Until"),
    Wrong("Lab-role-unknown.xml", _lab('<Identity Name="a"><May Role="king"/></Identity>'), "value",
          "Lab.Identity[0].May[0].Role"),
    Wrong("Lab-agent-nobody.xml", _lab('<Identity Name="a"><May Role="agent"/></Identity>'), "value",
          "Lab.Identity[0].May[0].Agents"),
    Wrong("Lab-pattern.xml", _lab('<Identity Name="a"><May Role="agent" Agents="a*b"/></Identity>'), "value",
          "Lab.Identity[0].May[0].Agents[0]"),
    Wrong("Lab-verb-unknown.xml", _lab('<Identity Name="a"><May Role="operator" Verbs="fly"/></Identity>'), "value",
          "Lab.Identity[0].May[0].Verbs[0]"),
    Wrong("Lab-verbs-of-a-viewer.xml", _lab('<Identity Name="a"><May Role="viewer" Verbs="pause"/></Identity>'),
          "value", "Lab.Identity[0].May[0].Verbs"),
    Wrong("Say-no-text.json", b'{"Tick":1}', "field", "Say.Text"),
    # Limits.
    Wrong("Actions-say-long.json", b'{"Say":"' + b"x" * 1001 + b'"}', "too-long", "Actions.Say"),
    Wrong("Actions-long.json", b'{"Say":"' + b" " * 4096 + b'"}', "too-long", "Actions"),
    Wrong("Actions-mode-long.xml", b'<Actions Mode="' + b"m" * 65 + b'"/>', "too-long", "Actions.Mode"),
    Wrong("UserInput-long.xml", b"<UserInput>" + b" " * 4096 + b"</UserInput>", "too-long", "UserInput"),
    Wrong("Robot-parts.xml", _robot('<Part X="0" Y="0" Length="1" Width="1" Bottom="0" Top="1"/>' * 33, ""),
          "too-many", "Robot.Part"),
    Wrong("Robot-sensors.xml", _robot("".join(f'<Bumper Id="b{index}"/>' for index in range(65))),
          "too-many", "Robot"),
    Wrong("Robot-rays.xml",
          _robot('<Lidar Id="l" X="0" Y="0" Z="0" DirectionDeg="0" FovDeg="270" Rays="1441" MaxRange="9"/>'),
          "value", "Robot.Lidar[0].Rays"),
    # Robots.
    Wrong("Robot-cone-zero.xml", _robot("<Bumper Id='b'/>" + _proximity(ConeDeg="0") + _proximity(Id="c")),
          "value", "Robot.Proximity[0].ConeDeg"),
    Wrong("Robot-cone-zero.json",
          b'{"Length":1.0,"Width":0.5,"Proximity":[{"Id":"a","X":0.0,"Y":0.0,"Z":0.4,"DirectionDeg":0.0,'
          b'"ConeDeg":0,"MaxRange":4.0}]}', "value", "Robot.Proximity[0].ConeDeg"),
    Wrong("Robot-no-id.xml", _robot(_proximity() + _proximity(Id="")), "field", "Robot.Proximity[1].Id"),
    Wrong("Robot-id-twice.xml", _robot(_proximity() + '<Bumper Id="a"/>'), "value", "Robot.Bumper[0].Id"),
    Wrong("Robot-id-space.xml", _robot(_proximity(Id="a b")), "value", "Robot.Proximity[0].Id"),
    Wrong("Robot-ranges.xml", _robot(_proximity(MinRange="4.0")), "value", "Robot.Proximity[0].MaxRange"),
    Wrong("Robot-height.xml", _robot("", 'Length="1.0" Width="0.5" Height="0.1"'), "field", "Robot.Height"),
    Wrong("Robot-part-flat.xml", _robot('<Part X="0" Y="0" Length="1" Width="1" Bottom="1" Top="1"/>', ""),
          "value", "Robot.Part[0].Top"),
    Wrong("Robot-both-forms.xml", _robot('<Part X="0" Y="0" Length="1" Width="1" Bottom="0" Top="1"/>'),
          "field", "Robot.Length"),
    Wrong("Robot-no-form.json", b'{"Kind":"ghost"}', "field", "Robot.Length"),
    Wrong("Robot-mind-with-motors.json", b'{"Role":"mind","TopSpeed":1.0}', "field", "Robot.TopSpeed"),
    Wrong("Robot-file-with-name.xml", _robot("", 'Format="iw.v1" Name="a" Length="1" Width="1"'),
          "field", "Robot.Name"),
    Wrong("Robot-file-version.xml", _robot("", 'Format="iw.v2" Length="1" Width="1"'), "version", "Robot.Format"),
    Wrong("Robot-name-capital.xml", _robot("", 'Name="Chair1" Length="1" Width="1"'), "value", "Robot.Name"),
    Wrong("Robot-name-star.json", b'{"Name":"*","Length":1.0,"Width":1.0}', "value", "Robot.Name"),
    Wrong("Robot-inertia-one.json", b'{"AccelerationCurve":1.0,"Length":1.0,"Width":1.0}', "value",
          "Robot.AccelerationCurve"),
    Wrong("Robot-far.json", b'{"Length":1.0,"Width":1.0,"Position":{"X":10000.5,"Y":0.0,"Heading":0.0}}', "value",
          "Robot.Position.X"),
    Wrong("Robot-user-input.xml", _robot("", 'UserInput="drive steer" Length="1" Width="1"'),
          "value", "Robot.UserInput[1]"),
    # Readings and poses.
    Wrong("Measures-value-without-ok.json", _measures('{"Proximity":[{"Id":"a","Value":1.0,"Status":"near"}]}'),
          "field", "Measures.Sensors.Proximity[0].Value"),
    Wrong("Measures-ok-without-value.json", _measures('{"Compass":[{"Id":"a"}]}'),
          "field", "Measures.Sensors.Compass[0].Value"),
    Wrong("Measures-lidar-lengths.json",
          _measures('{"Lidar":[{"Id":"l","StartDeg":0,"StepDeg":1,"Ranges":[1.0,null],"Statuses":["ok"]}]}'),
          "value", "Measures.Sensors.Lidar[0].Statuses"),
    Wrong("Measures-lidar-null-ok.json",
          _measures('{"Lidar":[{"Id":"l","StartDeg":0,"StepDeg":1,"Ranges":[null],"Statuses":["ok"]}]}'),
          "value", "Measures.Sensors.Lidar[0].Ranges[0]"),
    Wrong("Measures-no-tick.json", f'{{"Run":"{RUN}","Time":0.0}}'.encode(), "field", "Measures.Tick"),
    Wrong("Pose-covariance.xml", b'<Pose X="0" Y="0" Heading="0" Covariance="1 0 0"/>', "value", "Pose.Covariance"),
    Wrong("Pose-covariance-word.xml", b'<Pose X="0" Y="0" Heading="0" Covariance="1 - 0 1 0 1"/>', "value",
          "Pose.Covariance[1]"),
    Wrong("Pose-heading.json", b'{"X":0.0,"Y":0.0,"Heading":7.0}', "value", "Pose.Heading"),
    Wrong("UserInput-button.json", b'{"Buttons":[1,64]}', "value", "UserInput.Buttons[1]"),
    Wrong("UserInput-buttons-number.json", b'{"Buttons":1}', "value", "UserInput.Buttons"),
    # Verbs.
    Wrong("Load-neither.json", b'{"Seed":"1"}', "field", "Load"),
    Wrong("Load-both.json", b'{"Name":"ward","Map":{"Format":"iw.v1","Name":"m"}}', "field", "Load"),
    Wrong("Speed-zero.json", b'{"Factor":0.0}', "value", "Speed.Factor"),
    Wrong("Step-zero.xml", b'<Step Count="0"/>', "value", "Step.Count"),
    Wrong("Spawn-mind.json", b'{"Robot":{"Role":"mind"}}', "value", "Spawn.Robot"),
    Wrong("Teleport-nowhere.xml", b'<Teleport Agent="a"/>', "field", "Teleport.Position"),
    Wrong("Take-long.json", b'{"Agent":"a","Seconds":61.0}', "value", "Take.Seconds"),
    Wrong("Pause-field.json", b'{"Now":true}', "field", "Pause.Now"),
    # Files.
    Wrong("Map-version.xml", _map("", 'Format="iw.v2" Name="m"'), "version", "Map.Format"),
    Wrong("Map-no-format.xml", _map("", 'Name="m"'), "field", "Map.Format"),
    Wrong("Map-wall-point.xml", _map(f'<Wall Thickness="0.1">{_CORNER}</Wall>'), "value", "Map.Wall[0]"),
    Wrong("Map-wall-line.xml", _map(f"<Wall>{_CORNER * 2}</Wall>"), "value", "Map.Wall[0]"),
    Wrong("Map-obstacle-low.xml", _map(f'<Obstacle Name="o" Bottom="1" Top="1">{_CORNER * 3}</Obstacle>'), "value",
          "Map.Obstacle[0].Top"),
    Wrong("Map-grid-twice.xml", _map("<Grid/><Grid/>"), "malformed", "Map"),
    Wrong("Scene-cast-twice.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Robot="r" Mind="m"/>'
          b'<Cast Name="a" Robot="r" Mind="m"/></Scene>', "value", "Scene.Cast[1].Name"),
    Wrong("Scene-cast-mindless.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Robot="r"/></Scene>', "value", "Scene.Cast[0]"),
    Wrong("Scene-command-placeholder.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Command="./mine {nmae}"/></Scene>', "value",
          "Scene.Cast[0].Command"),
    Wrong("Scene-experiment-on-nobody.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Experiment Subject="a"/></Scene>', "value",
          "Scene.Experiment.Subject"),
    Wrong("Scene-experiment-no-row.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Robot="r" Mind="m"/><Experiment Subject="a">'
          b'<Factor Name="f"><Level Name="x"/></Factor><Compare First="x" Second="y"/></Experiment></Scene>',
          "value", "Scene.Experiment.Compare[0].Second"),
    Wrong("Scene-reach-nobody.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><End><Reach Agent="a" Place="p" Within="1"/></End></Scene>',
          "value", "Scene.End.Reach[0].Agent"),
    # Rules that span fields, in the other encoding or in another place.
    Wrong("Robot-id-twice.json", b'{"Length":1.0,"Width":1.0,"Bumper":[{"Id":"a"}],"Compass":[{"Id":"a"}]}', "value",
          "Robot.Bumper[0].Id"),
    Wrong("Robot-sensors.json", b'{"Length":1.0,"Width":1.0,"Bumper":['
          + b",".join(b'{"Id":"b%d"}' % index for index in range(65)) + b"]}", "too-many", "Robot"),
    Wrong("Robot-ranges.json", b'{"Length":1.0,"Width":1.0,"Proximity":[{"Id":"a","X":0.0,"Y":0.0,"Z":0.4,'
          b'"DirectionDeg":0.0,"ConeDeg":30.0,"MinRange":4.0,"MaxRange":4.0}]}',
          "value", "Robot.Proximity[0].MaxRange"),
    Wrong("Robot-part-flat.json",
          b'{"Part":[{"X":0.0,"Y":0.0,"Length":1.0,"Width":1.0,"Bottom":1.0,"Top":1.0}]}', "value",
          "Robot.Part[0].Top"),
    Wrong("Robot-both-forms.json",
          b'{"Width":1.0,"Part":[{"X":0.0,"Y":0.0,"Length":1.0,"Width":1.0,"Bottom":0.0,"Top":1.0}]}', "field",
          "Robot.Width"),
    Wrong("Robot-no-form.xml", _robot("", 'Length="1.0"'), "field", "Robot.Width"),
    Wrong("Robot-mind-with-part.xml",
          _robot('<Part X="0" Y="0" Length="1" Width="1" Bottom="0" Top="1"/>', 'Role="mind"'), "field", "Robot.Part"),
    Wrong("Robot-file-with-role.json", b'{"Format":"iw.v1","Role":"body","Length":1.0,"Width":1.0}', "field",
          "Robot.Role"),
    Wrong("Robot-source-real.json", b'{"Length":1.0,"Width":1.0,"Bumper":[{"Id":"a","Source":"real"}]}', "value",
          "Robot.Bumper[0].Source"),
    Wrong("Robot-source-real.xml", _robot('<Bumper Id="a" Source="real"/>'), "value", "Robot.Bumper[0].Source"),
    Wrong("Robot-position-twice.xml", _robot('<Position X="0" Y="0" Heading="0"/>' * 2), "malformed", "Robot"),
    Wrong("Robot-type-element.xml", _robot("<Type>real</Type>"), "field", "Robot.Type"),
    Wrong("Robot-top-speed-space.xml", _robot("", 'Length="1.0" Width="0.5" TopSpeed="1.0 "'), "value",
          "Robot.TopSpeed"),
    Wrong("Robot-many-parts.json", b'{"Part":[' + b",".join(
        [b'{"X":0.0,"Y":0.0,"Length":1.0,"Width":1.0,"Bottom":0.0,"Top":1.0}'] * 33) + b"]}", "too-many", "Robot.Part"),
    Wrong("Measures-lidar-value-none.json",
          _measures('{"Lidar":[{"Id":"l","StartDeg":0,"StepDeg":1,"Ranges":[1.0,2.0],"Statuses":["ok","none"]}]}'),
          "value", "Measures.Sensors.Lidar[0].Ranges[1]"),
    Wrong("Measures-lidar-value-none.xml",
          f'<Measures Run="{RUN}" Tick="1" Time="0.0"><Sensors><Lidar Id="l" StartDeg="0" StepDeg="1" Ranges="1.0 2.0" '
          'Statuses="ok none"/></Sensors></Measures>'.encode(), "value", "Measures.Sensors.Lidar[0].Ranges[1]"),
    Wrong("Measures-lidar-lengths.xml",
          f'<Measures Run="{RUN}" Tick="1" Time="0.0"><Sensors><Lidar Id="l" StartDeg="0" StepDeg="1" Ranges="1.0 2.0" '
          'Statuses="ok"/></Sensors></Measures>'.encode(), "value", "Measures.Sensors.Lidar[0].Statuses"),
    Wrong("Measures-value-without-ok.xml",
          f'<Measures Run="{RUN}" Tick="1" Time="0.0"><Sensors><Compass Id="c" Value="0.5" Status="fault"/></Sensors>'
          "</Measures>".encode(), "field", "Measures.Sensors.Compass[0].Value"),
    Wrong("Measures-sensors-twice.xml",
          f'<Measures Run="{RUN}" Tick="1" Time="0.0"><Sensors/><Sensors/></Measures>'.encode(), "malformed",
          "Measures"),
    Wrong("Pose-covariance.json", b'{"X":0.0,"Y":0.0,"Heading":0.0,"Covariance":[1.0,0.0,0.0]}', "value",
          "Pose.Covariance"),
    Wrong("Pose-covariance-negative.json",
          b'{"X":0.0,"Y":0.0,"Heading":0.0,"Covariance":[1.0,0.0,0.0,-1.0,0.0,1.0]}', "value", "Pose.Covariance"),
    Wrong("Pose-covariance-negative.xml", b'<Pose X="0" Y="0" Heading="0" Covariance="1 0 0 -1 0 1"/>', "value",
          "Pose.Covariance"),
    Wrong("CrewActions-twice.json", b'{"Crew":"c","Parts":1,"Actions":[%s,%s]}' % ((_CREW_MEMBER,) * 2),
          "value", "CrewActions.Actions[1].Agent"),
    Wrong("CrewJoin-name.json", b'{"Crew":"c","Instance":"%s","Robot":[{"Length":1.0,"Width":1.0}]}' % _SESSION,
          "field", "CrewJoin.Robot[0].Name"),
    Wrong("CrewJoin-name.xml",
          b'<CrewJoin Crew="c" Instance="%s"><Robot Length="1.0" Width="1.0"/></CrewJoin>' % _SESSION,
          "field", "CrewJoin.Robot[0].Name"),
    Wrong("CrewLeave-session.json", b'{"Crew":"c","Leave":[{"Agent":"a"}]}', "field", "CrewLeave.Leave[0].Session"),
    Wrong("CrewActions-part.json", b'{"Crew":"c","Part":1,"Parts":1}', "value", "CrewActions.Part"),
    Wrong("CrewActions-part.xml", b'<CrewActions Crew="c" Part="1" Parts="1"/>', "value", "CrewActions.Part"),
    Wrong("Load-both.xml", b'<Load Name="ward"><Map Format="iw.v1" Name="m"/></Load>', "field", "Load"),
    Wrong("Load-wall-line.json",
          b'{"Map":{"Format":"iw.v1","Name":"m","Wall":[{"Corner":[{"X":0.0,"Y":0.0},{"X":1.0,"Y":0.0}]}]}}', "value",
          "Load.Map.Wall[0]"),
    Wrong("Spawn-real.xml", b'<Spawn><Robot Type="real" Length="1" Width="1"/></Spawn>', "value", "Spawn.Robot"),
    Wrong("Map-wall-under.xml", _map(f'<Wall Bottom="2.5">{_CORNER * 3}</Wall>'), "value", "Map.Wall[0].Height"),
    Wrong("Map-wall-low.xml", _map(f'<Wall Bottom="1" Height="1">{_CORNER * 3}</Wall>'), "value",
          "Map.Wall[0].Height"),
    Wrong("Map-zone-line.xml", _map(f'<Zone Name="z">{_CORNER * 2}</Zone>'), "value", "Map.Zone[0]"),
    Wrong("Map-zone-line.json",
          b'{"Format":"iw.v1","Name":"m","Zone":[{"Name":"z","Corner":[{"X":0.0,"Y":0.0},{"X":1.0,"Y":0.0}]}]}',
          "value", "Map.Zone[0]"),
    Wrong("Scene-option-twice.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Robot="r" Mind="m"><Option Name="o" Value="1"/>'
          b'<Option Name="o" Value="2"/></Cast></Scene>', "value", "Scene.Cast[0].Option[1].Name"),
    Wrong("Scene-bridge-nobody.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Bridge Agent="a"/></Scene>', "value", "Scene.Bridge[0].Agent"),
    Wrong("Scene-bridge-twice.xml",
          b'<Scene Format="iw.v1" Name="s" Map="m"><Cast Name="a" Robot="r" Mind="m"/><Bridge Agent="a"/>'
          b'<Bridge Agent="a"/></Scene>', "value", "Scene.Bridge[1].Agent"),
    Wrong("Scene-no-level.xml", _experiment('<Factor Name="f"/>'), "value", "Scene.Experiment.Factor[0]"),
    Wrong("Scene-level-twice.xml", _experiment('<Factor Name="f"><Level Name="x"/><Level Name="x"/></Factor>'), "value",
          "Scene.Experiment.Factor[0].Level[1].Name"),
    Wrong("Scene-compare-alone.xml", _experiment('<Factor Name="f"><Level Name="x"/></Factor><Compare First="x"/>'),
          "value", "Scene.Experiment.Compare[0]"),
    Wrong("Scene-two-factors-no-row.xml",
          _experiment('<Factor Name="f"><Level Name="x"/></Factor><Factor Name="g"><Level Name="y"/></Factor>'
                      '<Compare First="x" Expect="collision-free"/>'), "value", "Scene.Experiment.Compare[0].First"),
    Wrong("Scene-umbmark-same.xml",
          _experiment('<Factor Name="f"><Level Name="x"/></Factor><Umbmark Left="x" Right="x" Side="1"/>'), "value",
          "Scene.Experiment.Umbmark.Right"),
    Wrong("Scene-uniform-of-nothing.xml", _experiment('<Uniform Name="X" Low="0" High="1"/>'), "value",
          "Scene.Experiment.Uniform[0]"),
    Wrong("Scene-uniform-of-two.xml", _experiment('<Uniform Place="p" Obstacle="o" Name="X" Low="0" High="1"/>'),
          "value", "Scene.Experiment.Uniform[0]"),
    Wrong("Scene-uniform-obstacle-turned.xml",
          _experiment('<Uniform Obstacle="o" Name="HeadingDeg" Low="0" High="1"/>'), "value",
          "Scene.Experiment.Uniform[0].Name"),
    Wrong("Scene-uniform-place-size.xml", _experiment('<Uniform Place="p" Name="Size" Low="0" High="1"/>'), "value",
          "Scene.Experiment.Uniform[0].Name"),
    Wrong("Scene-uniform-nobody.xml", _experiment('<Uniform Agent="b" Name="speed" Low="0" High="1"/>'), "value",
          "Scene.Experiment.Uniform[0].Agent"),
    Wrong("Scene-uniform-place-follows.xml",
          _experiment('<Uniform Place="p" Name="X" Low="0" High="1" Follows="Y"/>'), "value",
          "Scene.Experiment.Uniform[0].Follows"),
    Wrong("Scene-uniform-reversed.xml", _experiment('<Uniform Place="p" Name="X" Low="1" High="0"/>'), "value",
          "Scene.Experiment.Uniform[0].High"),
    Wrong("Scene-uniform-twice.xml",
          _experiment('<Uniform Place="p" Name="X" Low="0" High="1"/><Uniform Place="p" Name="X" Low="0" High="2"/>'),
          "value", "Scene.Experiment.Uniform[1].Name"),
)  # fmt: skip


def class_of(file: str) -> type[Record]:
    """Return the class of a vector from its file name, up to the first `-` or `.`.

    Raises:
        ValueError: There is no class of this name.
    """
    name = file.replace(".", "-").partition("-")[0]
    if name not in NAMES:
        raise ValueError(f"expected a name that begins with a class ({', '.join(NAMES)}), got {file!r}")
    return NAMES[name]


def encoding_of_file(file: str) -> Encoding:
    """Return the encoding of a vector from the end of its file name."""
    return Encoding.XML if file.endswith(".xml") else Encoding.JSON


def _with_session(wrong: Wrong) -> Wrong:
    """Return a wrong document with the Session that its class needs, so that it is refused for its own reason only."""
    if class_of(wrong.name) not in {Actions, Say, Pose} or "no-session" in wrong.name:
        return wrong
    root = ROOTS[class_of(wrong.name)].encode()
    session = SESSION.encode()
    if wrong.data.startswith(b'{"'):
        return wrong._replace(data=b'{"Session":"%s",%s' % (session, wrong.data[1:]))
    data = re.sub(rb"<%s(?=[ />])" % root, b'<%s Session="%s"' % (root, session), wrong.data, count=1)
    return wrong._replace(data=data)


REFUSED: Final = tuple(map(_with_session, _REFUSED))
"""Documents that must be refused, each for one reason."""


def index_of(wrong: Wrong, text: str) -> dict[str, Any]:
    """Return the entry of a document in the index of refused documents."""
    name = wrong.name.replace(".", "-").partition("-")[0]
    return {"File": wrong.name, "Class": name, "Code": wrong.code, "Place": wrong.where, "Text": text}
