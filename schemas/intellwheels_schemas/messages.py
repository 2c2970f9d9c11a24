"""Every message, once. XML, JSON, XSD, JSON Schema and KEYS.md are made from these classes.

A field's name on the wire is its Python name in PascalCase. Scalars and lists of scalars are
XML attributes, records are child elements, `Marked` text is an element of its own or the
element's text. SI units, but where a name ends in Deg. Defaults are not written.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Literal, get_args

import msgspec
from msgspec import Meta, field

MAX_INTEGER: Final = 2**53 - 1
"""The largest integer that every language's JSON keeps exactly."""

# XML 1.0's characters without carriage return, which XML readers turn into a line feed.
TEXT_PATTERN: Final = "^[\t\n\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]*\\Z"
NAME_PATTERN: Final = r"^[a-z][a-z0-9_-]{0,31}\Z"
ID_PATTERN: Final = r"^[A-Za-z][A-Za-z0-9_.-]{0,31}\Z"
WORD_PATTERN: Final = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}\Z"
HEX_PATTERN: Final = r"^[0-9a-f]{16}\Z"

_ELEMENT = {"xml": "element"}
_CONTENT = {"xml": "text"}


def _expected(words: str) -> dict[str, Any]:
    """Return what errors call a text that has a form."""
    return {"expected": words}


def _unit(unit: str) -> dict[str, Any]:
    return {"unit": unit}


# Words and text.
Name = Annotated[
    str,
    Meta(
        pattern=NAME_PATTERN,
        description="a name in keys",
        max_length=32,
        extra=_expected("a name of a-z, 0-9, _ and -, a letter first, at most 32 characters"),
    ),
]
Id = Annotated[
    str,
    Meta(
        pattern=ID_PATTERN,
        description="an id, unique in its robot",
        max_length=32,
        extra=_expected("an id of letters, digits, _, . and -, a letter first, at most 32 characters"),
    ),
]
Word = Annotated[
    str,
    Meta(
        pattern=WORD_PATTERN,
        description="a word",
        max_length=64,
        extra=_expected("a word of letters, digits, _, . and -, at most 64 characters"),
    ),
]
Hex = Annotated[
    str,
    Meta(
        pattern=HEX_PATTERN,
        description="16 lower-case hex digits",
        max_length=16,
        extra=_expected("16 lower-case hex digits"),
    ),
]
Seed = Annotated[str, Meta(pattern=TEXT_PATTERN, description="a seed: any text", max_length=64)]
Title = Annotated[str, Meta(pattern=TEXT_PATTERN, description="text for people", max_length=200)]
# 1,000 is the wire's bound; a simulation's own say limit is lower.
ElementText = Annotated[str, Meta(pattern=TEXT_PATTERN, description="text", max_length=1000, extra=_ELEMENT)]
# An element cannot tell empty text from none, so text that may be absent is not empty.
OptionalText = Annotated[
    str, Meta(pattern=TEXT_PATTERN, description="text", min_length=1, max_length=1000, extra=_CONTENT)
]
ContentText = Annotated[str, Meta(pattern=TEXT_PATTERN, description="text", max_length=1000, extra=_CONTENT)]

# Whole numbers.
Tick = Annotated[int, Meta(ge=0, le=MAX_INTEGER, description="a tick: steps since the run began")]
Count = Annotated[int, Meta(ge=0, le=MAX_INTEGER, description="a count")]
Signed = Annotated[int, Meta(ge=-MAX_INTEGER, le=MAX_INTEGER, description="a signed count")]
Every = Annotated[int, Meta(ge=1, le=1000, description="sampled once in so many ticks", extra=_unit("ticks"))]
Button = Annotated[int, Meta(ge=0, le=63, description="numbers of the buttons that are pressed")]
Cycles = Annotated[int, Meta(ge=0, le=1000, description="a number of ticks", extra=_unit("ticks"))]

# Quantities.
Coordinate = Annotated[float, Meta(ge=-10_000.0, le=10_000.0, extra=_unit("m"))]
Length = Annotated[float, Meta(ge=0.0, le=1000.0, extra=_unit("m"))]
Size = Annotated[float, Meta(gt=0.0, le=1000.0, extra=_unit("m"))]
Heading = Annotated[
    float,
    Meta(ge=-2 * math.pi, le=2 * math.pi, description="anticlockwise from x; written in (-pi, pi]", extra=_unit("rad")),
]
Degrees = Annotated[float, Meta(ge=-360.0, le=360.0, description="anticlockwise from x", extra=_unit("deg"))]
Cone = Annotated[float, Meta(gt=0.0, le=360.0, description="the full angle", extra=_unit("deg"))]
StepDegrees = Annotated[float, Meta(ge=0.0, le=90.0, description="quantisation step; 0: none", extra=_unit("deg"))]
NoiseDegrees = Annotated[float, Meta(ge=0.0, le=180.0, description="standard deviation", extra=_unit("deg"))]
Share = Annotated[float, Meta(ge=0.0, le=1.0, description="a share", extra=_unit("1"))]
Inertia = Annotated[
    float, Meta(ge=0.0, lt=1.0, description="share of the last power kept in a cycle of 50 ms", extra=_unit("1"))
]
Power = Annotated[float, Meta(ge=-1.0, le=1.0, description="share of full power", extra=_unit("1"))]
Velocity = Annotated[float, Meta(ge=-100.0, le=100.0, extra=_unit("m/s"))]
TopSpeed = Annotated[float, Meta(ge=0.0, le=50.0, description="speed of a wheel at power 1", extra=_unit("m/s"))]
TurnRate = Annotated[float, Meta(ge=-1000.0, le=1000.0, description="anticlockwise", extra=_unit("rad/s"))]
Limit = Annotated[float, Meta(gt=0.0, le=1000.0, description="a limit; absent: none")]
Acceleration = Annotated[float, Meta(ge=-1000.0, le=1000.0, extra=_unit("m/s2"))]
AccelerationNoise = Annotated[float, Meta(ge=0.0, le=100.0, description="standard deviation", extra=_unit("m/s2"))]
TurnRateNoise = Annotated[float, Meta(ge=0.0, le=100.0, description="standard deviation", extra=_unit("rad/s"))]
Volts = Annotated[float, Meta(ge=0.0, le=10.0, description="standard deviation of its voltage", extra=_unit("V"))]
Incidence = Annotated[
    float, Meta(ge=0.0, le=90.0, description="largest angle between ray and normal that returns", extra=_unit("deg"))
]
WayVariance = Annotated[
    float, Meta(ge=0.0, le=1.0, description="variance of a wheel's way, m2 a metre rolled", extra=_unit("m"))
]
Walk = Annotated[float, Meta(ge=0.0, le=1000.0, description="standard deviation that a bias gains in a second")]
StepSize = Annotated[float, Meta(ge=0.0, le=1000.0, description="quantisation step; 0: none")]
FigureRatio = Annotated[float, Meta(ge=0.5, le=2.0, extra=_unit("1"))]
Seconds = Annotated[float, Meta(ge=0.0, le=1e9, extra=_unit("s"))]
Period = Annotated[float, Meta(ge=0.001, le=1.0, description="simulated time of a tick", extra=_unit("s"))]
Stamp = Annotated[float, Meta(ge=0.0, le=1e12, description="Unix time", extra=_unit("s"))]
Factor = Annotated[float, Meta(gt=0.0, le=1000.0, description="simulated time over wall time", extra=_unit("1"))]
Ratio = Annotated[float, Meta(ge=0.0, le=1e9, extra=_unit("1"))]
Range = Annotated[float, Meta(ge=0.0, le=20_000.0, extra=_unit("m"))]
SayRange = Annotated[float, Meta(gt=0.0, le=20_000.0, extra=_unit("m"))]
SayDelay = Annotated[float, Meta(ge=0.0, le=3600.0, extra=_unit("s"))]
Variance = Annotated[float, Meta(ge=-1e9, le=1e9)]
Normal = Annotated[float, Meta(ge=-1.0, le=1.0, extra=_unit("1"))]

# Closed lists.
RobotType = Literal["real", "simulated"]
Role = Literal["both", "body", "mind"]
Mount = Literal["body", "start"]
Source = Literal["simulated", "real"]
Model = Literal["ideal", "infrared", "sonar"]
Status = Literal["ok", "none", "near", "fault"]
InputWord = Literal["drive", "words", "goal"]
MotorState = Literal["drive", "timeout", "rested", "paused", "taken", "stale"]
ClockState = Literal["waiting", "running", "paused", "ended"]
Pace = Literal["realtime", "free", "lockstep"]
Miss = Literal["strict", "elastic"]
FormatTag = Literal["iw.v1"]
RefusedCode = Literal[
    "already-here", "no-token", "no-body", "no-place", "overlaps", "name", "field", "value", "limit", "version",
    "truth", "mount", "real-in-lockstep", "full",
]  # fmt: skip
ErrorCode = Literal[
    "malformed", "encoding", "version", "field", "value", "too-long", "too-many", "late", "early", "answered",
    "session", "lease", "not-joined", "role",
]  # fmt: skip
EventCode = Literal[
    "joined", "left", "lost", "returned", "contact", "parted", "stale", "fresh", "late", "rested", "back", "timeout",
    "taken", "released", "spawned", "deleted", "teleported", "paused", "resumed", "speed", "reset", "loaded", "ended",
]  # fmt: skip
ResultCode = Literal["ok", "unsupported", "not-found", "incorrect-state", "failed"]


class Record(msgspec.Struct, rename="pascal", frozen=True, omit_defaults=True, forbid_unknown_fields=True):
    """What every document and every part of one is.

    `kw_only` is not inherited and type checkers want `frozen` said again: each class says both.
    """


# ---------------------------------------------------------------- geometry


class Corner(Record, frozen=True, kw_only=True):
    """A corner of a polygon or line on the floor."""

    x: Coordinate
    y: Coordinate


class Position(Record, frozen=True, kw_only=True):
    """A pose on the floor."""

    x: Coordinate
    y: Coordinate
    heading: Heading


class Goal(Record, frozen=True, kw_only=True):
    """Where somebody wants to be; without a heading any will do."""

    x: Coordinate
    y: Coordinate
    heading: Heading | None = None


class Part(Record, frozen=True, kw_only=True):
    """An upright box of a body: the offset of its centre, its size along and across, its z range."""

    x: Coordinate
    y: Coordinate
    length: Size
    width: Size
    bottom: Length
    top: Size


# ---------------------------------------------------------------- sensors, declared


class Proximity(Record, frozen=True, kw_only=True):
    """The nearest distance inside a wedge."""

    id: Id
    x: Coordinate
    y: Coordinate
    z: Length
    direction_deg: Degrees
    cone_deg: Cone
    min_range: Length = 0.0
    max_range: Size
    model: Model = "ideal"
    noise_volts: Volts = 0.01
    dropout: Annotated[Share, Meta(description="share of samples that fail; not of ideal")] = 0.0
    crosstalk: Annotated[Share, Meta(description="sonar: share of others' chirps in sight taken for an echo")] = 0.0
    group: Annotated[Cycles, Meta(description="ticks that it fires after group 0, less than Every")] = 0
    mount: Mount = "body"
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Lidar(Record, frozen=True, kw_only=True):
    """Ranges by angle, from the first ray anticlockwise."""

    id: Id
    x: Coordinate
    y: Coordinate
    z: Length
    direction_deg: Degrees
    fov_deg: Cone
    rays: Annotated[int, Meta(ge=1, le=1440, description="number of rays")]
    min_range: Length = 0.0
    max_range: Size
    noise: Annotated[Length, Meta(description="standard deviation at least")] = 0.0
    noise_share: Annotated[Share, Meta(description="standard deviation as a share of the range")] = 0.0
    incidence_deg: Incidence = 90.0
    dropout: Annotated[Share, Meta(description="share of rays that fail")] = 0.0
    mount: Mount = "body"
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Encoders(Record, frozen=True, kw_only=True):
    """Ticks of both wheels since joining."""

    id: Id
    drift: WayVariance = 0.0
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Odometry(Record, frozen=True, kw_only=True):
    """The pose integrated from the robot's first encoders with the nominal figures; without any, from perfect ones."""

    id: Id
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Compass(Record, frozen=True, kw_only=True):
    """The heading."""

    id: Id
    noise_deg: NoiseDegrees = 0.0
    step_deg: StepDegrees = 0.0
    walk_deg: Annotated[Walk, Meta(extra=_unit("deg"))] = 0.0
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class GPS(Record, frozen=True, kw_only=True):
    """The position of a point of the body."""

    id: Id
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    noise: Annotated[Length, Meta(description="standard deviation on each axis")] = 0.0
    walk: Annotated[Walk, Meta(extra=_unit("m"))] = 0.0
    step: Annotated[StepSize, Meta(extra=_unit("m"))] = 0.0
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class IMU(Record, frozen=True, kw_only=True):
    """Acceleration along and across, and turn rate."""

    id: Id
    noise: AccelerationNoise = 0.0
    turn_noise: TurnRateNoise = 0.0
    walk: Annotated[Walk, Meta(extra=_unit("m/s2"))] = 0.0
    turn_walk: Annotated[Walk, Meta(extra=_unit("rad/s"))] = 0.0
    step: Annotated[StepSize, Meta(extra=_unit("m/s2"))] = 0.0
    turn_step: Annotated[StepSize, Meta(extra=_unit("rad/s"))] = 0.0
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Beacon(Record, frozen=True, kw_only=True):
    """The bearing of a named place, where it can be seen."""

    id: Id
    place: Word
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    z: Length = 0.0
    direction_deg: Degrees = 0.0
    cone_deg: Cone = 360.0
    max_range: Size = 20.0
    noise_deg: NoiseDegrees = 0.0
    walk_deg: Annotated[Walk, Meta(extra=_unit("deg"))] = 0.0
    step_deg: StepDegrees = 0.0
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Ground(Record, frozen=True, kw_only=True):
    """The zone under a point of the body."""

    id: Id
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Bumper(Record, frozen=True, kw_only=True):
    """Whether the body touches something."""

    id: Id
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


class Truth(Record, frozen=True, kw_only=True):
    """The true pose and speed; only where the simulation allows it."""

    id: Id
    every: Every = 1
    latency: Cycles = 0
    source: Source = "simulated"


# ---------------------------------------------------------------- joining


class Robot(Record, frozen=True, kw_only=True):
    """A body, its motors and sensors: how an agent joins, and the form of robot files.

    In a file `Format` is there and `Name`, `Role`, `Instance` and `Place` are not. The one-part
    form gives `Length`, `Width`, `Center` and `Top` in place of `Part`s. A mind that joins the body of
    another process gives only Role, Instance, Barrier, Crew and UserInput.
    """

    format: FormatTag | None = None
    name: Name | None = None
    type: RobotType = "simulated"
    kind: Annotated[Word, Meta(description="wheelchair, door, table, person or any word")] = "robot"
    role: Role = "both"
    instance: Hex | None = None
    barrier: Annotated[bool, Meta(description="lockstep awaits it; absent: whether it has motors")] | None = None
    crew: Name | None = None
    user_input: Annotated[tuple[InputWord, ...], Meta(max_length=3)] = ()
    place: (
        Annotated[Word, Meta(description="where to start; absent: Position, or the first free place of its kind")]
        | None
    ) = None
    hardware: Literal["real", "simulated"] = "real"
    top_speed: TopSpeed = 0.0
    acceleration_curve: Inertia = 0.0
    track: Annotated[Size, Meta(description="distance between the wheels")] = 0.6
    wheel_diameter: Size = 0.35
    encoder_ticks: Annotated[int, Meta(ge=1, le=1_000_000, description="ticks of a whole turn of a wheel")] = 2000
    wheel_ratio: Annotated[FigureRatio, Meta(description="true right wheel over true left one, UMBmark's E_d")] = 1.0
    wheel_scale: Annotated[FigureRatio, Meta(description="true mean wheel over WheelDiameter")] = 1.0
    track_ratio: Annotated[FigureRatio, Meta(description="true track over Track, UMBmark's E_b")] = 1.0
    command_timeout: Annotated[Seconds, Meta(description="absent: the simulation's own")] | None = None
    anchored: Annotated[bool, Meta(description="a hinge holds it: never slides")] = False
    acceleration_limit: Annotated[Limit, Meta(extra=_unit("m/s2"))] | None = None
    turn_limit: Annotated[Limit, Meta(extra=_unit("rad/s"))] | None = None
    motor_noise: Annotated[Share, Meta(description="standard deviation of a motor's output, as a share")] = 0.0
    slip: Annotated[Share, Meta(description="share by which blocked wheels turn on")] = 0.0
    length: Size | None = None
    width: Size | None = None
    center: (
        Annotated[Share, Meta(description="centre of movement from the rear edge, in lengths; absent: 0.5")] | None
    ) = None
    top: Annotated[Size, Meta(description="z of the upper face; absent: 1.3")] | None = None
    part: Annotated[tuple[Part, ...], Meta(max_length=32)] = ()
    position: Position | None = None
    proximity: tuple[Proximity, ...] = ()
    lidar: tuple[Lidar, ...] = ()
    encoders: tuple[Encoders, ...] = ()
    odometry: tuple[Odometry, ...] = ()
    compass: tuple[Compass, ...] = ()
    gps: tuple[GPS, ...] = field(default=(), name="GPS")
    imu: tuple[IMU, ...] = field(default=(), name="IMU")
    beacon: tuple[Beacon, ...] = ()
    ground: tuple[Ground, ...] = ()
    bumper: tuple[Bumper, ...] = ()
    truth: tuple[Truth, ...] = ()


class Parameters(Record, frozen=True, kw_only=True):
    """What an agent must know of the simulation it joined."""

    world: Name
    period: Period
    pace: Pace
    say_limit: Annotated[Count, Meta(description="code points of one say")]
    say_range: Range
    command_timeout: Seconds
    grace: Annotated[Seconds, Meta(description="wall time a lost token is waited for")]


class Joined(Record, frozen=True, kw_only=True):
    """The reply to a join that was accepted."""

    run: Hex
    tick: Tick
    session: Hex
    parameters: Parameters
    position: Position
    robot: Robot


class Refused(Record, frozen=True, kw_only=True):
    """The reply to a join that was not."""

    code: RefusedCode
    text: ContentText


class Leave(Record, frozen=True, kw_only=True):
    """A wish to leave; without a Session, of whoever writes the key."""

    run: Hex | None = None
    session: Hex | None = None


# ---------------------------------------------------------------- each tick


class Actions(Record, frozen=True, kw_only=True):
    """What an agent does in one tick. An absent motor keeps its command."""

    run: Hex | None = None
    session: Hex | None = None
    tick: Tick | None = None
    seq: Count | None = None
    left_motor: Power | None = None
    right_motor: Power | None = None
    mode: Word | None = None
    leave: bool = False
    goal: Goal | None = None
    say: ElementText | None = None


class AgentActions(Record, frozen=True, kw_only=True):
    """One agent's `Actions` within a crew's."""

    agent: Name
    run: Hex | None = None
    session: Hex | None = None
    tick: Tick | None = None
    seq: Count | None = None
    left_motor: Power | None = None
    right_motor: Power | None = None
    mode: Word | None = None
    leave: bool = False
    goal: Goal | None = None
    say: ElementText | None = None


class CrewActions(Record, frozen=True, kw_only=True):
    """The `Actions` of many bodies of one process."""

    crew: Name
    part: Count = 0
    parts: Count = 1
    actions: Annotated[tuple[AgentActions, ...], Meta(max_length=250)] = ()


class Say(Record, frozen=True, kw_only=True):
    """Words of an agent that wants to speak only."""

    run: Hex | None = None
    session: Hex | None = None
    tick: Tick | None = None
    seq: Count | None = None
    text: ContentText


class ProximityReading(Record, frozen=True, kw_only=True):
    """The nearest distance inside the wedge; a Value with Status ok only."""

    id: Id
    tick: Tick | None = None
    value: Range | None = None
    status: Status = "ok"


class LidarReading(Record, frozen=True, kw_only=True):
    """Ranges by angle; `null` (in XML `-`) where the status is not ok."""

    id: Id
    tick: Tick | None = None
    stamp: Seconds | None = None
    start_deg: Degrees
    step_deg: Degrees
    ranges: Annotated[tuple[Range | None, ...], Meta(max_length=1440)] = ()
    statuses: Annotated[tuple[Status, ...], Meta(max_length=1440)] = ()


class EncodersReading(Record, frozen=True, kw_only=True):
    """Ticks of each wheel since joining, forward positive."""

    id: Id
    tick: Tick | None = None
    left: Signed
    right: Signed


class OdometryReading(Record, frozen=True, kw_only=True):
    """The pose since joining by the nominal figures."""

    id: Id
    tick: Tick | None = None
    x: Coordinate
    y: Coordinate
    heading: Heading


class CompassReading(Record, frozen=True, kw_only=True):
    """The heading."""

    id: Id
    tick: Tick | None = None
    value: Heading | None = None
    status: Status = "ok"


class GPSReading(Record, frozen=True, kw_only=True):
    """A position."""

    id: Id
    tick: Tick | None = None
    x: Coordinate | None = None
    y: Coordinate | None = None
    status: Status = "ok"


class IMUReading(Record, frozen=True, kw_only=True):
    """Acceleration forward and to the left, and turn rate."""

    id: Id
    tick: Tick | None = None
    forward: Acceleration
    left: Acceleration
    turn_rate: TurnRate


class BeaconReading(Record, frozen=True, kw_only=True):
    """The bearing of the beacon in the body frame."""

    id: Id
    tick: Tick | None = None
    value: Heading | None = None
    status: Status = "ok"


class GroundReading(Record, frozen=True, kw_only=True):
    """The name of the zone; absent where there is none."""

    id: Id
    tick: Tick | None = None
    zone: Word | None = None


class BumperReading(Record, frozen=True, kw_only=True):
    """Whether the body touches something."""

    id: Id
    tick: Tick | None = None
    value: bool


class TruthReading(Record, frozen=True, kw_only=True):
    """The true pose and twist."""

    id: Id
    tick: Tick | None = None
    x: Coordinate
    y: Coordinate
    heading: Heading
    speed: Velocity
    turn_rate: TurnRate


class Sensors(Record, frozen=True, kw_only=True):
    """Readings by kind."""

    proximity: tuple[ProximityReading, ...] = ()
    lidar: tuple[LidarReading, ...] = ()
    encoders: tuple[EncodersReading, ...] = ()
    odometry: tuple[OdometryReading, ...] = ()
    compass: tuple[CompassReading, ...] = ()
    gps: tuple[GPSReading, ...] = field(default=(), name="GPS")
    imu: tuple[IMUReading, ...] = field(default=(), name="IMU")
    beacon: tuple[BeaconReading, ...] = ()
    ground: tuple[GroundReading, ...] = ()
    bumper: tuple[BumperReading, ...] = ()
    truth: tuple[TruthReading, ...] = ()


class Heard(Record, frozen=True, kw_only=True):
    """What another agent said."""

    sender: Name = field(name="From")
    tick: Tick
    seq: Count | None = None
    distance: Range
    text: ContentText


class UserInput(Record, frozen=True, kw_only=True):
    """What a person wants, latched by the simulator. Turn is positive to the left."""

    lease: Hex | None = None
    seq: Count | None = None
    forward: Power = 0.0
    turn: Power = 0.0
    buttons: Annotated[tuple[Button, ...], Meta(max_length=64)] = ()
    word: Word | None = None
    goal: Goal | None = None


class Measures(Record, frozen=True, kw_only=True):
    """What an agent perceives after `Tick` steps."""

    run: Hex
    tick: Tick
    time: Seconds
    collision: bool = False
    contact: bool = False
    sensors: Sensors | None = None
    message: tuple[Heard, ...] = ()
    user_input: UserInput | None = None


class AgentMeasures(Record, frozen=True, kw_only=True):
    """One agent's `Measures` within a crew's."""

    agent: Name
    run: Hex
    tick: Tick
    time: Seconds
    collision: bool = False
    contact: bool = False
    sensors: Sensors | None = None
    message: tuple[Heard, ...] = ()
    user_input: UserInput | None = None


class CrewMeasures(Record, frozen=True, kw_only=True):
    """The `Measures` of many bodies of one process."""

    crew: Name
    part: Count = 0
    parts: Count = 1
    measures: Annotated[tuple[AgentMeasures, ...], Meta(max_length=250)] = ()


class Pose(Record, frozen=True, kw_only=True):
    """Where a real chair is, by its bridge."""

    run: Hex | None = None
    session: Hex | None = None
    tick: Tick | None = None
    seq: Count | None = None
    x: Coordinate
    y: Coordinate
    heading: Heading
    stamp: Stamp | None = None
    covariance: Annotated[tuple[Variance, ...], Meta(description="xx xy xh yy yh hh")] = ()
    sensors: Sensors | None = None


class PowerInForce(Record, frozen=True, kw_only=True):
    """The power a real chair must give now, and why."""

    run: Hex
    tick: Tick
    left_motor: Power
    right_motor: Power
    state: MotorState = "drive"


class Error(Record, frozen=True, kw_only=True):
    """What was wrong with something an agent sent."""

    run: Hex
    tick: Tick
    code: ErrorCode
    where: Title | None = None
    seq: Count | None = None
    suppressed: Annotated[Count, Meta(description="errors not sent since the last")] = 0
    text: ContentText


# ---------------------------------------------------------------- the world, for viewers


class Entity(Record, frozen=True, kw_only=True):
    """A body's true state."""

    name: Name
    x: Coordinate
    y: Coordinate
    heading: Heading
    speed: Velocity = 0.0
    turn_rate: TurnRate = 0.0
    collision: bool = False
    contact: bool = False
    contacts: Annotated[Count, Meta(description="episodes of contact since the run began")] = 0
    state: MotorState = "drive"
    mode: Word | None = None
    goal: Goal | None = None
    say: ElementText | None = None


class WorldState(Record, frozen=True, kw_only=True):
    """Every body's true state, in parts."""

    run: Hex
    tick: Tick
    time: Seconds
    part: Count = 0
    parts: Count = 1
    entity: tuple[Entity, ...] = ()


class Body(Record, frozen=True, kw_only=True):
    """A body as accepted."""

    run: Hex
    tick: Tick
    owner: Annotated[Hex, Meta(description="the instance that joined as its body")] | None = None
    roles: tuple[Role, ...] = ()
    robot: Robot


class Event(Record, frozen=True, kw_only=True):
    """Something that happened, numbered."""

    run: Hex
    tick: Tick
    number: Count
    code: EventCode
    agent: Name | None = None
    other: Annotated[Word, Meta(description="the other body, or wall")] | None = None
    part: Count | None = None
    other_part: Count | None = None
    x: Coordinate | None = None
    y: Coordinate | None = None
    normal_x: Normal | None = None
    normal_y: Normal | None = None
    speed: Annotated[Velocity, Meta(description="closing speed of a contact, or the new speed factor")] | None = None
    text: OptionalText | None = None


class Events(Record, frozen=True, kw_only=True):
    """The events kept, from a number on."""

    run: Hex
    oldest: Count
    next: Count
    event: tuple[Event, ...] = ()


class Clock(Record, frozen=True, kw_only=True):
    """How far the run is."""

    run: Hex
    tick: Tick
    time: Seconds
    state: ClockState
    pace: Pace
    speed: Factor = 1.0
    factor: Annotated[Ratio, Meta(description="simulated time over wall time, of late")] = 0.0
    late: Annotated[Count, Meta(description="ticks that began late")] = 0
    hash: Hex
    stamp: Stamp
    waiting: Annotated[tuple[Name, ...], Meta(description="whom the barrier awaits")] = ()
    last: (
        Annotated[Tick, Meta(description="last tick of this run in the log that is played; absent: a live run")] | None
    ) = None


class MapInfo(Record, frozen=True, kw_only=True):
    """Which map is loaded."""

    run: Hex
    tick: Tick
    name: Word
    revision: Count
    hash: Hex


# ---------------------------------------------------------------- control


class Reach(Record, frozen=True, kw_only=True):
    """Met when the agent's centre of movement is near the place."""

    agent: Name
    place: Word
    within: Size


class Timeout(Record, frozen=True, kw_only=True):
    """Met after so much simulated time."""

    seconds: Annotated[float, Meta(gt=0.0, le=1e9, extra=_unit("s"))]


class End(Record, frozen=True, kw_only=True):
    """When a run ends: every `Reach` is met, or the time is over."""

    reach: tuple[Reach, ...] = ()
    timeout: Timeout | None = None


class Pause(Record, frozen=True, kw_only=True):
    """Stop stepping."""


class Resume(Record, frozen=True, kw_only=True):
    """Step on."""


class Step(Record, frozen=True, kw_only=True):
    """Step so often, then pause."""

    count: Annotated[int, Meta(ge=1, le=1_000_000, description="steps")] = 1


class Reset(Record, frozen=True, kw_only=True):
    """Begin the same map anew; joins stay."""

    seed: Seed | None = None
    end: End | None = None


class Speed(Record, frozen=True, kw_only=True):
    """Run at so many times real time."""

    factor: Factor


class Delete(Record, frozen=True, kw_only=True):
    """Take a body out."""

    agent: Name


class Take(Record, frozen=True, kw_only=True):
    """Make the simulator obey `user/<agent>`, for so long; 0 gives it back."""

    agent: Name
    lease: Hex | None = None
    seconds: Annotated[float, Meta(ge=0.0, le=60.0, extra=_unit("s"))] = 2.0


class OperatorSay(Record, frozen=True, kw_only=True):
    """Words of an operator, to one agent or to all. `<Say>` on the wire."""

    to: Name | None = None
    text: ContentText


class Save(Record, frozen=True, kw_only=True):
    """Keep the state; the reply names the slot."""


class Restore(Record, frozen=True, kw_only=True):
    """Go back to a kept state, at its tick, as a new run."""

    slot: Word


class Seek(Record, frozen=True, kw_only=True):
    """Go to a tick of a log that is played."""

    tick: Tick
    run: Annotated[Hex, Meta(description="which run of the log; absent: the one that is shown")] | None = None


class Quit(Record, frozen=True, kw_only=True):
    """End the simulator."""


class Spawn(Record, frozen=True, kw_only=True):
    """Put a body of the simulator's own somewhere."""

    robot: Robot
    position: Position | None = None


class Teleport(Record, frozen=True, kw_only=True):
    """Put a body somewhere else."""

    agent: Name
    position: Position


class Result(Record, frozen=True, kw_only=True):
    """The reply to a verb or a leave."""

    code: ResultCode
    run: Hex | None = None
    tick: Tick | None = None
    hash: Hex | None = None
    lease: Hex | None = None
    slot: Word | None = None
    text: OptionalText | None = None


# ---------------------------------------------------------------- files


class Wall(Record, frozen=True, kw_only=True):
    """A solid polygon, or with `Thickness` a line of 2 or more corners; from `Bottom` to `Height` above the floor."""

    height: Size = 2.5
    bottom: Length = 0.0
    thickness: Size | None = None
    corner: tuple[Corner, ...] = ()


class Doorway(Record, frozen=True, kw_only=True):
    """An opening; heading is the way through."""

    name: Word
    x: Coordinate
    y: Coordinate
    heading_deg: Degrees
    width: Size


class Obstacle(Record, frozen=True, kw_only=True):
    """A named solid that is no wall: a bed, a cupboard."""

    name: Word
    bottom: Length = 0.0
    top: Size
    corner: tuple[Corner, ...] = ()


class Zone(Record, frozen=True, kw_only=True):
    """A named area of the floor."""

    name: Word
    title: Title | None = None
    corner: tuple[Corner, ...] = ()


class Place(Record, frozen=True, kw_only=True):
    """A named pose. `<Position>` on the wire; without kinds, for any."""

    name: Word
    x: Coordinate
    y: Coordinate
    heading_deg: Degrees = 0.0
    kinds: tuple[Word, ...] = ()


class Grid(Record, frozen=True, kw_only=True):
    """The places of a map."""

    position: tuple[Place, ...] = ()


class Map(Record, frozen=True, kw_only=True):
    """A floor."""

    format: FormatTag
    name: Word
    title: Title | None = None
    source: Title | None = None
    wall: tuple[Wall, ...] = ()
    doorway: tuple[Doorway, ...] = ()
    obstacle: tuple[Obstacle, ...] = ()
    zone: tuple[Zone, ...] = ()
    grid: Grid | None = None


class Load(Record, frozen=True, kw_only=True):
    """Put another floor in: one the simulator knows by `Name`, or the `Map` itself."""

    name: Word | None = None
    seed: Seed | None = None
    map: Map | None = None
    end: End | None = None


class Option(Record, frozen=True, kw_only=True):
    """An option of a mind."""

    name: Word
    value: Annotated[str, Meta(pattern=TEXT_PATTERN, description="text", max_length=1000)]


class Cast(Record, frozen=True, kw_only=True):
    """An agent of a scene: who, with which body and mind, where."""

    name: Name
    robot: Title
    mind: Title
    place: Word | None = None
    option: tuple[Option, ...] = ()


class Hold(Record, frozen=True, kw_only=True):
    """What must hold at the end of a run."""

    contacts: Count | None = None
    reached: Literal["all"] | None = None


class Setting(Record, frozen=True, kw_only=True):
    """An option that a level gives an agent; without an agent, a rule of the simulation such as `SayRange`."""

    agent: Name | None = None
    name: Word
    value: Annotated[str, Meta(pattern=TEXT_PATTERN, description="text", max_length=1000)]


class Bridge(Record, frozen=True, kw_only=True):
    """One of the cast has a real chair in a laboratory: a second simulation of the same floor that plays the building.

    Of a scene it holds in every run, of a level where that is chosen, in the place of the scene's for the same agent.
    An option with a capital letter is a field of the chair as built, any other an option of `iw-bridge`.
    """

    agent: Name
    chair: Annotated[Title, Meta(description="its document as built; absent: the robot of the cast")] | None = None
    option: tuple[Option, ...] = ()


class Level(Record, frozen=True, kw_only=True):
    """A value of a factor: agents that stand in the place of those of the same name or beside them, and options."""

    name: Word
    title: Title | None = None
    real: Annotated[bool, Meta(description="the chair stands for one of hardware: its contacts are physical")] = False
    cast: tuple[Cast, ...] = ()
    bridge: tuple[Bridge, ...] = ()
    setting: tuple[Setting, ...] = ()


class Varied(Record, frozen=True, kw_only=True):
    """What an experiment varies."""

    name: Word
    title: Title | None = None
    level: tuple[Level, ...] = ()


class Compare(Record, frozen=True, kw_only=True):
    """Two rows that are compared by their seeds, and what is expected of the first; without a second, of it alone."""

    first: Title
    second: Title | None = None
    expect: Literal["better", "worse", "equivalent", "collision-free"] | None = None


class Umbmark(Record, frozen=True, kw_only=True):
    """Two rows whose chairs drive a square by odometry: their true wheel figures are found from where they end."""

    left: Annotated[Title, Meta(description="the row with squares to the left")]
    right: Annotated[Title, Meta(description="the row with squares to the right")]
    side: Annotated[Size, Meta(description="of the square")]


class Experiment(Record, frozen=True, kw_only=True):
    """Runs of a scene that are compared: every combination of levels is a row, its name theirs with `+` between."""

    subject: Annotated[Name, Meta(description="whose runs they are")]
    margin: Annotated[Share, Meta(description="difference of success up to which rows are equivalent")] = 0.15
    factor: tuple[Varied, ...] = ()
    compare: tuple[Compare, ...] = ()
    umbmark: Umbmark | None = None


class Scene(Record, frozen=True, kw_only=True):
    """A run to be started: the floor, the cast, the pace, the end and what must hold."""

    format: FormatTag
    name: Word
    title: Title | None = None
    map: Title
    seed: Seed = "1"
    period: Period = 0.05
    pace: Pace = "lockstep"
    miss: Miss = "strict"
    truth: Annotated[bool, Meta(description="agents may have truth sensors")] = False
    say_range: Annotated[SayRange, Meta(description="how far a say is heard")] = 8.0
    say_walls: Annotated[bool, Meta(description="walls and closed doors keep a say from being heard")] = False
    say_loss: Annotated[Share, Meta(description="share of what agents say that a listener misses")] = 0.0
    say_delay: Annotated[SayDelay, Meta(description="time a say takes beyond the next tick")] = 0.0
    cast: tuple[Cast, ...] = ()
    bridge: tuple[Bridge, ...] = ()
    end: End | None = None
    hold: Hold | None = None
    experiment: Experiment | None = None


DOCUMENTS: Final[dict[str, tuple[type[Record], ...]]] = {
    "Robot": (Robot,), "Joined": (Joined,), "Refused": (Refused,), "Leave": (Leave,), "Actions": (Actions,),
    "CrewActions": (CrewActions,), "CrewMeasures": (CrewMeasures,), "Say": (Say, OperatorSay), "Measures": (Measures,),
    "Pose": (Pose,), "Power": (PowerInForce,), "UserInput": (UserInput,), "Error": (Error,),
    "WorldState": (WorldState,), "Body": (Body,), "Event": (Event,), "Events": (Events,), "Clock": (Clock,),
    "MapInfo": (MapInfo,), "Map": (Map,), "Scene": (Scene,), "Result": (Result,), "Pause": (Pause,),
    "Resume": (Resume,), "Step": (Step,), "Reset": (Reset,), "Load": (Load,), "Speed": (Speed,), "Spawn": (Spawn,),
    "Delete": (Delete,), "Teleport": (Teleport,), "Take": (Take,), "Save": (Save,), "Restore": (Restore,),
    "Seek": (Seek,), "Quit": (Quit,),
}  # fmt: skip
"""The documents by the name of their XML root: where two share one, the key decides."""

ROOTS: Final[dict[type[Record], str]] = {kind: root for root, kinds in DOCUMENTS.items() for kind in kinds}
"""The XML root of each document class."""

REFUSED_CODES: Final[tuple[str, ...]] = get_args(RefusedCode)
ERROR_CODES: Final[tuple[str, ...]] = get_args(ErrorCode)
EVENT_CODES: Final[tuple[str, ...]] = get_args(EventCode)
RESULT_CODES: Final[tuple[str, ...]] = get_args(ResultCode)
