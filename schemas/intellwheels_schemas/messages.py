"""The contract: every message and every file for people, declared once.

XML, JSON, XSD, JSON Schema and KEYS.md are made from these classes. A field's name on the wire is its Python name in
PascalCase. Scalars and lists of scalars are XML attributes, records are child elements, `Marked` text is an element
of its own or the element's text. Defaults are not written.

Units are SI, except where a name ends in Deg. Two frames are used:

- map frame: the origin and axes of the loaded map, in metres; headings count anticlockwise from its x axis.
- body frame: the origin is the centre of movement, x points forward, y to the left.

The string below a field describes the field; KEYS.md and the schemas repeat it. A type that means the same in every
message, such as `Run`, has one description for all its fields. A test refuses a field without a description.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Literal, get_args

import msgspec
from msgspec import Meta, field

from intellwheels_schemas import defaults

MAX_INTEGER: Final = 2**53 - 1
"""The largest integer that JSON keeps exactly in every language."""

# XML 1.0's characters without carriage return, which XML readers turn into a line feed.
TEXT_PATTERN: Final = "^[\t\n\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]*\\Z"
AGENTS_PATTERN: Final = r"^(\*|[a-z][a-z0-9_-]{0,31}\*?)\Z"
# A rule checks what is left: 29 February.
DATE_PATTERN: Final = (
    r"^[0-9]{4}-((01|03|05|07|08|10|12)-(0[1-9]|[12][0-9]|3[01])|(04|06|09|11)-(0[1-9]|[12][0-9]|30)"
    r"|02-(0[1-9]|[12][0-9]))\Z"
)
NAME_PATTERN: Final = r"^[a-z][a-z0-9_-]{0,31}\Z"
ID_PATTERN: Final = r"^[A-Za-z][A-Za-z0-9_.-]{0,31}\Z"
WORD_PATTERN: Final = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}\Z"
HEX_PATTERN: Final = r"^[0-9a-f]{16}\Z"
CODE_PATTERN: Final = r"^[0-9a-f]{32}\Z"
KEY_PATTERN: Final = r"^[0-9a-f]{64}\Z"

_ELEMENT = {"xml": "element"}
_CONTENT = {"xml": "text"}


def _expected(words: str) -> dict[str, Any]:
    """Return what an error calls a text of a given form."""
    return {"expected": words}


def _unit(unit: str) -> dict[str, Any]:
    return {"unit": unit}


# ---------------------------------------------------------------- types of fields

# Words and text.
Name = Annotated[
    str,
    Meta(
        pattern=NAME_PATTERN,
        description="a name for use in keys",
        max_length=32,
        extra=_expected("a name of a-z, 0-9, _ and -, a letter first, at most 32 characters"),
    ),
]
NamePattern = Annotated[
    str,
    Meta(
        pattern=AGENTS_PATTERN,
        description="a name, or the beginning of names followed by *",
        max_length=33,
        extra=_expected("a name, the beginning of names followed by *, or *"),
    ),
]
Id = Annotated[
    str,
    Meta(
        pattern=ID_PATTERN,
        description="an identifier",
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
Code = Annotated[
    str,
    Meta(
        pattern=CODE_PATTERN,
        description="Code over the message, made with the Key from Joined; a message with another code is dropped.",
        max_length=32,
        extra=_expected("32 lower-case hex digits"),
    ),
]
SecretKey = Annotated[
    str,
    Meta(
        pattern=KEY_PATTERN,
        description="64 lower-case hex digits",
        max_length=64,
        extra=_expected("64 lower-case hex digits"),
    ),
]
Date = Annotated[
    str,
    Meta(
        pattern=DATE_PATTERN,
        description="a date, such as 2027-02-28",
        max_length=10,
        extra=_expected("a date such as 2027-02-28"),
    ),
]
Seed = Annotated[str, Meta(pattern=TEXT_PATTERN, description="a seed, any text", max_length=64)]
Title = Annotated[str, Meta(pattern=TEXT_PATTERN, description="text for people", max_length=200)]
# 1,000 is the bound of the wire; the limit of a simulation (SayLimit) is lower.
ElementText = Annotated[str, Meta(pattern=TEXT_PATTERN, description="text", max_length=1000, extra=_ELEMENT)]
# In XML, empty text and absent text look the same, so optional text is never empty.
OptionalText = Annotated[
    str, Meta(pattern=TEXT_PATTERN, description="text", min_length=1, max_length=1000, extra=_CONTENT)
]
ContentText = Annotated[str, Meta(pattern=TEXT_PATTERN, description="text", max_length=1000, extra=_CONTENT)]
OptionValue = Annotated[str, Meta(pattern=TEXT_PATTERN, description="Value of the option, as text.", max_length=1000)]

CommandLine = Annotated[
    str,
    Meta(
        pattern=TEXT_PATTERN,
        description="Words of a command line, in the quotes of a shell; {name}, {endpoint} and {world} are replaced.",
        max_length=1000,
    ),
]

# Whole numbers.
Tick = Annotated[int, Meta(ge=0, le=MAX_INTEGER, description="a tick")]
Count = Annotated[int, Meta(ge=0, le=MAX_INTEGER, description="a count")]
Signed = Annotated[int, Meta(ge=-MAX_INTEGER, le=MAX_INTEGER, description="a signed count")]
Every = Annotated[
    int,
    Meta(
        ge=1,
        le=1000,
        description="Sampling interval in ticks: 1 samples at every tick, 2 at every second tick.",
        extra=_unit("ticks"),
    ),
]
Button = Annotated[int, Meta(ge=0, le=63, description="the number of a button")]
Cycles = Annotated[int, Meta(ge=0, le=1000, description="a number of ticks", extra=_unit("ticks"))]

# Quantities.
Coordinate = Annotated[float, Meta(ge=-10_000.0, le=10_000.0, extra=_unit("m"))]
Length = Annotated[float, Meta(ge=0.0, le=1000.0, extra=_unit("m"))]
Size = Annotated[float, Meta(gt=0.0, le=1000.0, extra=_unit("m"))]
Heading = Annotated[
    float, Meta(ge=-2 * math.pi, le=2 * math.pi, description="an angle, anticlockwise", extra=_unit("rad"))
]
Degrees = Annotated[float, Meta(ge=-360.0, le=360.0, description="an angle, anticlockwise", extra=_unit("deg"))]
Cone = Annotated[float, Meta(gt=0.0, le=360.0, description="a full opening angle", extra=_unit("deg"))]
StepDegrees = Annotated[
    float,
    Meta(
        ge=0.0,
        le=90.0,
        description="Quantisation step: the angle is rounded to multiples of it; 0 means no rounding.",
        extra=_unit("deg"),
    ),
]
NoiseDegrees = Annotated[
    float,
    Meta(
        ge=0.0,
        le=180.0,
        description="Standard deviation of the Gaussian noise added to each sample of the angle.",
        extra=_unit("deg"),
    ),
]
WalkDegrees = Annotated[
    float,
    Meta(
        ge=0.0,
        le=1000.0,
        description="Random walk of the bias: standard deviation of its change in one second.",
        extra=_unit("deg"),
    ),
]
Share = Annotated[float, Meta(ge=0.0, le=1.0, description="a share", extra=_unit("1"))]
Inertia = Annotated[float, Meta(ge=0.0, lt=1.0, description="a share of the last power", extra=_unit("1"))]
Power = Annotated[float, Meta(ge=-1.0, le=1.0, description="a share of full power", extra=_unit("1"))]
Velocity = Annotated[float, Meta(ge=-100.0, le=100.0, extra=_unit("m/s"))]
TopSpeed = Annotated[float, Meta(ge=0.0, le=50.0, description="speed of a wheel at power 1", extra=_unit("m/s"))]
TurnRate = Annotated[float, Meta(ge=-1000.0, le=1000.0, description="anticlockwise", extra=_unit("rad/s"))]
Limit = Annotated[float, Meta(gt=0.0, le=1000.0, description="an upper limit")]
Acceleration = Annotated[float, Meta(ge=-1000.0, le=1000.0, extra=_unit("m/s2"))]
AccelerationNoise = Annotated[float, Meta(ge=0.0, le=100.0, description="standard deviation", extra=_unit("m/s2"))]
TurnRateNoise = Annotated[float, Meta(ge=0.0, le=100.0, description="standard deviation", extra=_unit("rad/s"))]
Volts = Annotated[float, Meta(ge=0.0, le=10.0, description="standard deviation of a voltage", extra=_unit("V"))]
Incidence = Annotated[float, Meta(ge=0.0, le=90.0, description="an angle of incidence", extra=_unit("deg"))]
WayVariance = Annotated[float, Meta(ge=0.0, le=1.0, description="m2 per metre", extra=_unit("m"))]
Walk = Annotated[float, Meta(ge=0.0, le=1000.0, description="standard deviation that a bias gains in a second")]
StepSize = Annotated[float, Meta(ge=0.0, le=1000.0, description="a quantisation step; 0 does not round")]
FigureRatio = Annotated[float, Meta(ge=0.5, le=2.0, description="a ratio to the nominal figure", extra=_unit("1"))]
Seconds = Annotated[float, Meta(ge=0.0, le=1e9, extra=_unit("s"))]
PingDelay = Annotated[float, Meta(ge=0.0, le=0.1, description="a delay", extra=_unit("s"))]
Period = Annotated[
    float, Meta(ge=0.001, le=1.0, description="Simulated time from one tick to the next.", extra=_unit("s"))
]
Stamp = Annotated[float, Meta(ge=0.0, le=1e12, description="Unix time", extra=_unit("s"))]
Factor = Annotated[float, Meta(gt=0.0, le=1000.0, description="simulated time over wall time", extra=_unit("1"))]
Ratio = Annotated[float, Meta(ge=0.0, le=1e9, description="a ratio", extra=_unit("1"))]
Range = Annotated[float, Meta(ge=0.0, le=20_000.0, extra=_unit("m"))]
Travel = Annotated[float, Meta(ge=0.0, le=1e9, extra=_unit("m"))]
Turned = Annotated[float, Meta(ge=0.0, le=2 * math.pi, description="an angle", extra=_unit("rad"))]
SayRange = Annotated[float, Meta(gt=0.0, le=20_000.0, extra=_unit("m"))]
SayDelay = Annotated[float, Meta(ge=0.0, le=3600.0, extra=_unit("s"))]
Offset = Annotated[float, Meta(ge=-10_000.0, le=10_000.0, description="an offset")]
Variance = Annotated[float, Meta(ge=-1e9, le=1e9)]
Normal = Annotated[float, Meta(ge=-1.0, le=1.0, description="a component of a unit vector", extra=_unit("1"))]

# Closed lists.
RobotType = Literal["real", "simulated"]
Role = Literal["both", "body", "mind"]
Mount = Literal["body", "start"]
Source = Literal["simulated", "real"]
Model = Literal["ideal", "infrared", "sonar"]
SonarName = Literal["srf04", "srf08", "srf10", "srf485", "srf235", "hc-sr04", "polaroid-6500"]
Status = Literal["ok", "none", "near", "fault"]
DoorKind = Literal["hinged", "double-hinged", "sliding", "double-sliding"]
Side = Literal["left", "right"]
InputWord = Literal["drive", "words", "goal"]
MotorState = Literal["drive", "timeout", "rested", "paused", "taken", "stale"]
ClockState = Literal["waiting", "running", "paused", "ended"]
Pace = Literal["realtime", "free", "lockstep"]
Miss = Literal["strict", "elastic"]
NewRun = Literal["follow", "restart"]
FormatTag = Literal["iw.v1"]
ControlVerb = Literal[
    "pause", "resume", "step", "reset", "load", "speed", "spawn", "delete", "teleport", "take", "say", "save",
    "restore", "seek", "quit",
]  # fmt: skip
LabRole = Literal["simulator", "operator", "viewer", "agent", "mind", "bridge", "recorder", "gateway"]
RefusedCode = Literal[
    "already-here", "no-token", "no-body", "no-place", "overlaps", "name", "field", "value", "limit", "version",
    "truth", "mount", "real-in-lockstep", "full",
]  # fmt: skip
ErrorCode = Literal[
    "malformed", "encoding", "version", "field", "value", "too-long", "too-many", "late", "early", "answered",
    "session", "lease", "not-joined", "role", "deleted", "forged",
]  # fmt: skip
EventCode = Literal[
    "joined", "left", "lost", "returned", "contact", "parted", "stale", "fresh", "late", "rested", "back", "timeout",
    "taken", "released", "spawned", "deleted", "teleported", "paused", "resumed", "speed", "reset", "loaded", "ended",
]  # fmt: skip
ResultCode = Literal["ok", "unsupported", "not-found", "incorrect-state", "failed"]

# Types that mean the same in every message, so their fields need no sentence of their own.
Run = Annotated[
    Hex,
    Meta(description="Id of the run. A start, reset, load or restore gives a new id; older state is then invalid."),
]
SentRun = Annotated[Hex, Meta(description="Run that the message is for; absent means the current run.")]
# A mind leaves it out; the harness fills it in. On the wire it is always there, so `shape_of` counts it as required.
SentSession = Annotated[
    Hex,
    Meta(
        description="Session from Joined; a message without it, or with another one, is dropped.",
        extra={"sent": "always"},
    ),
]
SentTick = Annotated[Tick, Meta(description="Tick of the Measures that this answers; absent means the current tick.")]
SentSeq = Annotated[
    Count, Meta(description="Sender's message counter. Of several messages for one tick, the highest Seq counts.")
]
StateTick = Annotated[Tick, Meta(description="Number of steps since the start of the run.")]
Time = Annotated[Seconds, Meta(description="Simulated time since the start of the run: Tick times Period.")]
PartNumber = Annotated[Count, Meta(description="Index of this part of a split message, counted from 0.")]
PartCount = Annotated[Count, Meta(description="Number of parts of the split message.")]
SiteCoordinate = Annotated[
    float, Meta(ge=-100_000_000.0, le=100_000_000.0, description="a coordinate of the site, in m or degrees")
]
MapX = Annotated[Coordinate, Meta(description="X coordinate in the map frame.")]
MapY = Annotated[Coordinate, Meta(description="Y coordinate in the map frame.")]
MapHeading = Annotated[
    Heading,
    Meta(description="Heading in the map frame: 0 along x, positive anticlockwise; written in (-pi, pi]."),
]
SensorId = Annotated[Id, Meta(description="Id of the sensor, unique among all sensors of the robot.")]
SensorX = Annotated[
    Coordinate, Meta(description="Distance of the sensor ahead of the centre of movement (x in the body frame).")
]
SensorY = Annotated[
    Coordinate, Meta(description="Distance of the sensor to the left of the centre of movement (y in the body frame).")
]
SensorZ = Annotated[Length, Meta(description="Height of the sensor above the floor.")]
SensorDirection = Annotated[
    Degrees, Meta(description="Direction of the sensor's axis in the body frame: 0 is forward, positive to the left.")
]
SensorMount = Annotated[
    Mount,
    Meta(
        description="What the sensor is fixed to: body moves with the robot; start stays at the robot's start pose, "
        "as on a door frame."
    ),
]
Latency = Annotated[Cycles, Meta(description="Delay in ticks from taking a sample to reporting it.")]
SensorSource = Annotated[
    Source,
    Meta(description="Source of the samples: the simulator, or a real robot, which sends them in its Pose."),
]
Dropout = Annotated[Share, Meta(description="Share of samples that fail and are reported with Status fault.")]
RangeNoise = Annotated[Length, Meta(description="Standard deviation of the Gaussian noise on each axis.")]
ReadingId = Annotated[Id, Meta(description="Id of the sensor, as declared in Robot.")]
SampleTick = Annotated[
    Tick, Meta(description="Tick at which the sample was taken; absent means the Tick of the message.")
]
ReadingStatus = Annotated[
    Status,
    Meta(
        description="Status of the reading: ok (has a value), none (nothing found), near (closer than MinRange) or "
        "fault (the sample failed)."
    ),
]
TimeoutSetting = Annotated[
    Seconds, Meta(description="Simulated time without a motor command after which both powers become 0.")
]
AgentName = Annotated[Name, Meta(description="Name of the agent.")]
Format = Annotated[FormatTag, Meta(description="Version of the file format.")]
Kept = Annotated[Hex, Meta(description="Hash of the world's state at that tick.")]
NewSeed = Annotated[Seed, Meta(description="Seed of the new run's noise; absent keeps the current one.")]


class Record(msgspec.Struct, rename="pascal", frozen=True, omit_defaults=True, forbid_unknown_fields=True):
    """Base of every document and every part of one.

    `kw_only` is not inherited, and type checkers require `frozen` again, so each class states both.
    """


# ---------------------------------------------------------------- geometry


class Corner(Record, frozen=True, kw_only=True):
    """A corner of a polygon or polyline on the map."""

    x: MapX
    y: MapY


class Position(Record, frozen=True, kw_only=True):
    """A pose on the map: the position of the centre of movement, and the heading."""

    x: MapX
    y: MapY
    heading: MapHeading


class Goal(Record, frozen=True, kw_only=True):
    """A target pose. Without `Heading`, any heading is accepted."""

    x: MapX
    y: MapY
    heading: MapHeading | None = None


class Part(Record, frozen=True, kw_only=True):
    """An upright box that is part of a body."""

    x: Coordinate
    """Distance of the box's centre ahead of the centre of movement (x in the body frame)."""
    y: Coordinate
    """Distance of the box's centre to the left of the centre of movement (y in the body frame)."""
    length: Size
    """Size of the box along the body's x axis."""
    width: Size
    """Size of the box along the body's y axis."""
    bottom: Length
    """Height of the lower face above the floor."""
    top: Size
    """Height of the upper face above the floor; must be more than Bottom."""


# ---------------------------------------------------------------- sensors, as declared


class Proximity(Record, frozen=True, kw_only=True):
    """A proximity sensor: the distance to the nearest thing inside a wedge."""

    id: SensorId
    x: SensorX
    y: SensorY
    z: SensorZ
    direction_deg: SensorDirection
    cone_deg: Cone
    """Full opening angle of the wedge, half of it to each side of DirectionDeg."""
    min_range: Length = 0.0
    """Shortest distance that can be measured; anything closer is reported as near."""
    max_range: Size
    """Longest distance that can be measured; if nothing is nearer, the status is none."""
    model: Model = "ideal"
    """Error model: ideal (no errors), infrared (noise grows with distance) or sonar (detects only echoes). Latency of a
    sonar must be at least its longer delay plus the time of sound to MaxRange and back. Every must be at least the
    larger of that time of sound and the ping period of its Device (50 ms without one), plus the difference between its
    two delays."""
    noise_volts: Volts = 0.01
    """Infrared only: standard deviation of the sensor's voltage. The voltage is 0.47 V m divided by the distance."""
    dropout: Dropout = 0.0
    """Share of samples that fail and are reported as fault; must be 0 for the ideal model."""
    device: SonarName | None = None
    """Sonar only: name of a device, whose published figures then apply; ConeDeg, ranges and Every must fit them."""
    crosstalk: Share = 0.0
    """Sonar only: share of the pings of other sonars that the sensor takes for its own echo, if it can hear them."""
    ping_delay: PingDelay = 0.0
    """Sonar only: time from the tick of a sample to its ping."""
    second_ping_delay: PingDelay = 0.0
    """Sonar only: the same time for the second, fourth, ... ping, so that crosstalk differs from ping to ping."""
    group: Cycles = 0
    """Firing group: number of ticks by which the sensor samples later than group 0; must be less than Every."""
    mount: SensorMount = "body"
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Lidar(Record, frozen=True, kw_only=True):
    """A scanning range finder: distances along rays, anticlockwise from the first ray."""

    id: SensorId
    x: SensorX
    y: SensorY
    z: SensorZ
    direction_deg: SensorDirection
    fov_deg: Cone
    """Field of view; the first ray points half of it to the right of DirectionDeg."""
    rays: Annotated[int, Meta(ge=1, le=1440)]
    """Number of rays in a scan, evenly spaced over the field of view."""
    min_range: Length = 0.0
    """Shortest distance that can be measured; anything closer is reported as near."""
    max_range: Size
    """Longest distance that can be measured; if nothing is nearer, the status is none."""
    noise: Length = 0.0
    """Standard deviation of a range; if NoiseShare gives a larger one, that one applies."""
    noise_share: Share = 0.0
    """Standard deviation of a range as a share of that range."""
    incidence_deg: Incidence = 90.0
    """Largest angle between a ray and the surface normal at which the ray still returns."""
    dropout: Dropout = 0.0
    mount: SensorMount = "body"
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Encoders(Record, frozen=True, kw_only=True):
    """Wheel encoders: counts of both wheels since joining."""

    id: SensorId
    drift: WayVariance = 0.0
    """Variance of the error in a wheel's distance, in m2 per metre rolled; models slip and uneven ground."""
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Odometry(Record, frozen=True, kw_only=True):
    """An odometry sensor: the pose since joining, by dead reckoning.

    It uses the counts of the robot's first encoders, or exact counts if the robot has no encoders.
    """

    id: SensorId
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Compass(Record, frozen=True, kw_only=True):
    """A compass: the heading of the body."""

    id: SensorId
    noise_deg: NoiseDegrees = 0.0
    step_deg: StepDegrees = 0.0
    walk_deg: WalkDegrees = 0.0
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class GPS(Record, frozen=True, kw_only=True):
    """A positioning sensor: the position of a point of the body."""

    id: SensorId
    x: SensorX = 0.0
    y: SensorY = 0.0
    noise: RangeNoise = 0.0
    walk: Annotated[Walk, Meta(extra=_unit("m"))] = 0.0
    """Random walk of the bias: standard deviation of its change on each axis in one second."""
    step: Annotated[StepSize, Meta(extra=_unit("m"))] = 0.0
    """Quantisation step of each coordinate; 0 means no rounding."""
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class IMU(Record, frozen=True, kw_only=True):
    """An inertial unit: acceleration forward and to the left, and turn rate, at the centre of movement."""

    id: SensorId
    noise: AccelerationNoise = 0.0
    """Standard deviation of the Gaussian noise on each acceleration."""
    turn_noise: TurnRateNoise = 0.0
    """Standard deviation of the Gaussian noise on the turn rate."""
    walk: Annotated[Walk, Meta(extra=_unit("m/s2"))] = 0.0
    """Random walk of the bias that each acceleration has: standard deviation of its change in one second."""
    turn_walk: Annotated[Walk, Meta(extra=_unit("rad/s"))] = 0.0
    """Random walk of the bias of the turn rate: standard deviation of its change in one second."""
    step: Annotated[StepSize, Meta(extra=_unit("m/s2"))] = 0.0
    """Quantisation step of each acceleration; 0 means no rounding."""
    turn_step: Annotated[StepSize, Meta(extra=_unit("rad/s"))] = 0.0
    """Quantisation step of the turn rate; 0 means no rounding."""
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Beacon(Record, frozen=True, kw_only=True):
    """A beacon sensor: the bearing of a named place of the map, while it is in sight."""

    id: SensorId
    place: Word
    """Name of the Position in the map's Grid at which the beacon stands."""
    x: SensorX = 0.0
    y: SensorY = 0.0
    z: SensorZ = 0.0
    direction_deg: SensorDirection = 0.0
    cone_deg: Cone = 360.0
    """Full opening angle in which the sensor sees the beacon, half of it to each side of DirectionDeg."""
    max_range: Size = 20.0
    """Longest distance at which the sensor sees the beacon."""
    noise_deg: NoiseDegrees = 0.0
    walk_deg: WalkDegrees = 0.0
    step_deg: StepDegrees = 0.0
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Ground(Record, frozen=True, kw_only=True):
    """A ground sensor: the zone of the map under a point of the body."""

    id: SensorId
    x: SensorX = 0.0
    y: SensorY = 0.0
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Bumper(Record, frozen=True, kw_only=True):
    """A bumper all around the body: whether it touches something."""

    id: SensorId
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


class Truth(Record, frozen=True, kw_only=True):
    """A sensor for the true pose and twist. It is refused unless the simulation allows it."""

    id: SensorId
    every: Every = 1
    latency: Latency = 0
    source: SensorSource = "simulated"


# ---------------------------------------------------------------- joining


class Robot(Record, frozen=True, kw_only=True):
    """A body with its motors and sensors: the request to join, and the content of a robot file.

    A file has `Format`, and no `Name`, `Role`, `Instance` or `Place`. A body of one box may have `Length`, `Width`,
    `Center` and `Top` instead of a `Part`. A mind that joins a body of another process may have only `Role`,
    `Instance`, `Barrier`, `Crew` and `UserInput`.
    """

    format: Annotated[FormatTag, Meta(description="Version of the file format; only in robot files.")] | None = None
    name: Name | None = None
    """Name of the agent; if present, it must equal the name in the key."""
    type: RobotType = "simulated"
    """What moves the body: the simulator, or a real robot whose bridge sends its Pose."""
    kind: Word = "robot"
    """What the body is, for viewers and for choosing a start place: wheelchair, door, table, person or any word."""
    role: Role = "both"
    """What joins: a body that obeys Power, a mind that answers Measures for a body of another process, or both."""
    instance: Hex | None = None
    """Id of the joining process, random at each start; the same as in its liveliness token."""
    barrier: bool | None = None
    """Whether a lockstep run waits for the agent's answer; absent means yes for a mind or a body with motors."""
    crew: Name | None = None
    """Name of the crew whose keys carry the agent's Actions and Measures; absent means that it has its own keys."""
    user_input: Annotated[tuple[InputWord, ...], Meta(max_length=3)] = ()
    """Kinds of UserInput that the mind accepts in its Measures: drive (the stick), words or goal."""
    place: Word | None = None
    """Name of the place to start at; absent means the pose in Position, or the first free place for this Kind."""
    hardware: Literal["real", "simulated"] = "real"
    """Hardware of a real robot; simulated hardware may also run in lockstep and at speeds other than 1."""
    top_speed: TopSpeed = 0.0
    """Speed of a wheel's rim at power 1; 0 means that the body has no motors."""
    acceleration_curve: Inertia = 0.0
    """Inertia of the motors: share of the last power that is kept after 50 ms; 0 means none, 1 would never move."""
    track: Size = 0.6
    """Nominal distance between the left and the right wheel."""
    wheel_diameter: Size = 0.35
    """Nominal diameter of both driven wheels."""
    encoder_ticks: Annotated[int, Meta(ge=1, le=1_000_000)] = 2000
    """Encoder counts in one full turn of a wheel."""
    wheel_ratio: FigureRatio = 1.0
    """True diameter of the right wheel divided by that of the left wheel (E_d of the UMBmark test)."""
    wheel_scale: FigureRatio = 1.0
    """True mean diameter of the wheels divided by WheelDiameter."""
    track_ratio: FigureRatio = 1.0
    """True track divided by Track (E_b of the UMBmark test)."""
    command_timeout: Seconds | None = None
    """Simulated time without a motor command after which both powers become 0; absent means that of the simulation."""
    anchored: bool = False
    """Whether the body turns about a fixed hinge, like a door, and never slides."""
    acceleration_limit: Annotated[Limit, Meta(extra=_unit("m/s2"))] | None = None
    """Largest change of a wheel's speed per second; absent means no limit."""
    turn_limit: Annotated[Limit, Meta(extra=_unit("rad/s"))] | None = None
    """Largest turn rate in either direction; a larger one is reduced to it. Absent means no limit."""
    motor_noise: Share = 0.0
    """Standard deviation of a motor's output, as a share of it. A deviation is held for 50 ms of simulated time."""
    slip: Share = 0.0
    """How far the wheels of a blocked body spin: 0 not at all, 1 as if the body were free."""
    length: Size | None = None
    """Length of a one-box body along its x axis; only without Part."""
    width: Size | None = None
    """Width of a one-box body along its y axis; only without Part."""
    center: Share | None = None
    """Distance of a one-box body's centre of movement from the rear edge, as a share of Length; absent means 0.5."""
    top: Size | None = None
    """Height of the upper face of a one-box body above the floor; absent means 1.3."""
    part: Annotated[tuple[Part, ...], Meta(max_length=32)] = ()
    """Boxes that make up the body, for contact and for the sensors of other bodies."""
    position: Position | None = None
    """Pose to start at, if no Place is given. On a map with outer walls it must be within the box of all walls,
    obstacles and places; a map without outer walls has no boundary. A real robot may start anywhere."""
    proximity: tuple[Proximity, ...] = ()
    """Proximity sensors on the body."""
    lidar: tuple[Lidar, ...] = ()
    """Scanning range finders on the body."""
    encoders: tuple[Encoders, ...] = ()
    """Wheel encoders; each entry counts both wheels."""
    odometry: tuple[Odometry, ...] = ()
    """Dead-reckoning sensors, which integrate encoder counts."""
    compass: tuple[Compass, ...] = ()
    """Compasses, which measure the heading."""
    gps: tuple[GPS, ...] = field(default=(), name="GPS")
    """Positioning sensors, which measure map coordinates."""
    imu: tuple[IMU, ...] = field(default=(), name="IMU")
    """Inertial units, which measure acceleration and turn rate."""
    beacon: tuple[Beacon, ...] = ()
    """Sensors that measure the bearing of a place."""
    ground: tuple[Ground, ...] = ()
    """Sensors that report the zone under the body."""
    bumper: tuple[Bumper, ...] = ()
    """Contact sensors all around the body."""
    truth: tuple[Truth, ...] = ()
    """Sensors that report the true pose; refused unless the simulation allows them."""


class Parameters(Record, frozen=True, kw_only=True):
    """Settings of the simulation that an agent needs to know."""

    world: Name
    """Name of the world, as in its keys."""
    period: Period
    pace: Pace
    """How time passes: realtime, free (as fast as possible) or lockstep (waits for every member of the barrier)."""
    say_limit: Count
    """Longest message that an agent may send to others, in Unicode code points."""
    say_range: Range
    """Largest distance between the sender and a receiver of a message."""
    command_timeout: TimeoutSetting
    grace: Seconds
    """Wall time from the loss of a liveliness token to the removal of its agent."""


class Joined(Record, frozen=True, kw_only=True):
    """The reply to a join that was accepted."""

    run: Run
    tick: Tick
    """First tick at which the agent takes part."""
    session: Hex
    """Id of this join. Send it with Actions, Say and Pose, and as ?session= when joining again."""
    parameters: Parameters
    """Settings of the simulation."""
    position: Position
    """Start pose of the body."""
    robot: Robot
    """Robot as the simulator accepted it."""
    key: SecretKey | None = None
    """Key for the codes of Pose and Power, 32 bytes in hex; only for the body of a real robot, in its first Joined."""


class Refused(Record, frozen=True, kw_only=True):
    """The reply to a join that was refused."""

    code: RefusedCode
    """Reason, for programs."""
    text: ContentText
    """Reason, for people: the place, what was expected and what was received."""


class Leave(Record, frozen=True, kw_only=True):
    """A request to leave, from the process that has the Session."""

    run: SentRun | None = None
    session: SentSession | None = None


class CrewJoin(Record, frozen=True, kw_only=True):
    """A request to join with many agents of one process; later requests add agents to the crew, up to 250 in all."""

    crew: Name
    """Name of the crew, as in the key."""
    instance: Hex
    """Id of the joining process, random at each start; the same as in the liveliness tokens of its agents."""
    robot: Annotated[tuple[Robot, ...], Meta(max_length=250)] = ()
    """Robots of the agents, each with its Name; simulated, with the role both or mind."""


class AgentJoined(Record, frozen=True, kw_only=True):
    """An agent of a crew that has joined."""

    agent: Name
    """Name in the agent's `Robot` of the request."""
    session: Hex
    """Id of this agent's join. Send it with its Actions and Say."""
    position: Position
    """Start pose of the body."""
    robot: Robot
    """Robot as the simulator accepted it."""


class AgentRefused(Refused, frozen=True, kw_only=True):
    """An agent of a crew that was refused."""

    agent: Name
    """Name in the agent's `Robot` of the request."""


class CrewJoined(Record, frozen=True, kw_only=True):
    """The reply to a request to join with many agents: each is accepted or refused by itself."""

    crew: Name
    """Name of the crew, as in the key."""
    run: Run
    tick: Tick
    """First tick at which the agents take part."""
    parameters: Parameters
    """Settings of the simulation."""
    joined: Annotated[tuple[AgentJoined, ...], Meta(max_length=250)] = ()
    """Agents that have joined."""
    refused: Annotated[tuple[AgentRefused, ...], Meta(max_length=250)] = ()
    """Agents that were refused."""


class AgentLeave(Leave, frozen=True, kw_only=True):
    """The `Leave` of one agent of a crew."""

    agent: Name
    """Name of the agent that leaves."""


class CrewLeave(Record, frozen=True, kw_only=True):
    """A request to leave with many agents of a crew; one that is not there does not prevent the others."""

    crew: Name
    """Name of the crew, as in the key."""
    leave: Annotated[tuple[AgentLeave, ...], Meta(max_length=250)] = ()
    """Agents that leave, each with its Session."""


# ---------------------------------------------------------------- every tick


class Actions(Record, frozen=True, kw_only=True):
    """The commands of an agent for one tick. An absent motor keeps its last command."""

    run: SentRun | None = None
    session: SentSession | None = None
    tick: SentTick | None = None
    seq: SentSeq | None = None
    left_motor: Power | None = None
    """Power of the left motor, positive forward; absent keeps the last command and does not renew its time-out."""
    right_motor: Power | None = None
    """Power of the right motor, positive forward; absent keeps the last command and does not renew its time-out."""
    mode: Word | None = None
    """What the mind is doing, in one word, for viewers and logs."""
    leave: bool = False
    """Whether the agent leaves the simulation after this tick."""
    goal: Goal | None = None
    """Where the mind is going, for viewers."""
    say: ElementText | None = None
    """Message to the agents in range, which receive it in their next Measures."""


class AgentActions(Actions, frozen=True, kw_only=True):
    """The `Actions` of one agent of a crew."""

    agent: Name
    """Name of the agent that acts."""


class CrewActions(Record, frozen=True, kw_only=True):
    """The `Actions` of many agents of one process."""

    crew: Name
    """Name of the crew, as in the key."""
    part: PartNumber = 0
    parts: PartCount = 1
    actions: Annotated[tuple[AgentActions, ...], Meta(max_length=250)] = ()
    """Actions of the crew's agents, each agent once."""


class Say(Record, frozen=True, kw_only=True):
    """A message to other agents, sent separately from `Actions`."""

    run: SentRun | None = None
    session: SentSession | None = None
    tick: SentTick | None = None
    seq: SentSeq | None = None
    text: ContentText
    """Text of the message to the agents in range."""


class ProximityReading(Record, frozen=True, kw_only=True):
    """A distance from a proximity sensor; `Value` is there only when `Status` is ok."""

    id: ReadingId
    tick: SampleTick | None = None
    value: Range | None = None
    """Distance from the sensor to the nearest thing inside the wedge."""
    status: ReadingStatus = "ok"


class LidarReading(Record, frozen=True, kw_only=True):
    """A scan of a lidar. A range is `null` (`-` in XML) where its status is not ok."""

    id: ReadingId
    tick: SampleTick | None = None
    stamp: Seconds | None = None
    """Simulated time of the scan since the start of the run."""
    start_deg: Degrees
    """Angle of the first ray in the body frame: 0 is forward, positive to the left."""
    step_deg: Degrees
    """Angle from each ray to the next, positive anticlockwise."""
    ranges: Annotated[tuple[Range | None, ...], Meta(max_length=1440)] = ()
    """Distance along each ray from the sensor, from StartDeg on."""
    statuses: Annotated[tuple[Status, ...], Meta(max_length=1440)] = ()
    """Status of each ray, as many as Ranges: ok, none (nothing in range), near (too close) or fault."""


class EncodersReading(Record, frozen=True, kw_only=True):
    """Counts of both wheels since joining; EncoderTicks counts are one turn."""

    id: ReadingId
    tick: SampleTick | None = None
    left: Signed
    """Counts of the left wheel since joining, forward positive."""
    right: Signed
    """Counts of the right wheel since joining, forward positive."""


class OdometryReading(Record, frozen=True, kw_only=True):
    """The pose by dead reckoning, in the body frame at the moment of joining."""

    id: ReadingId
    tick: SampleTick | None = None
    x: Coordinate
    """Distance ahead of the start, along the body frame's x axis at joining."""
    y: Coordinate
    """Distance to the left of the start, along the body frame's y axis at joining."""
    heading: Heading
    """Heading relative to the body frame at joining, positive anticlockwise; in (-pi, pi]."""


class CompassReading(Record, frozen=True, kw_only=True):
    """A heading from a compass; `Value` is there only when `Status` is ok."""

    id: ReadingId
    tick: SampleTick | None = None
    value: MapHeading | None = None
    status: ReadingStatus = "ok"


class GPSReading(Record, frozen=True, kw_only=True):
    """A position; `X` and `Y` are there only when `Status` is ok."""

    id: ReadingId
    tick: SampleTick | None = None
    x: MapX | None = None
    y: MapY | None = None
    status: ReadingStatus = "ok"


class IMUReading(Record, frozen=True, kw_only=True):
    """Acceleration and turn rate of the body at its centre of movement."""

    id: ReadingId
    tick: SampleTick | None = None
    forward: Acceleration
    """Acceleration along the body's x axis, forward positive, averaged over the last tick."""
    left: Acceleration
    """Acceleration along the body's y axis, to the left positive: speed times turn rate."""
    turn_rate: TurnRate
    """Rate of turn, positive anticlockwise."""


class BeaconReading(Record, frozen=True, kw_only=True):
    """The bearing of a beacon; `Value` is there only when `Status` is ok."""

    id: ReadingId
    tick: SampleTick | None = None
    value: Heading | None = None
    """Direction of the beacon in the body frame: 0 is forward, positive to the left; in (-pi, pi]."""
    status: ReadingStatus = "ok"


class GroundReading(Record, frozen=True, kw_only=True):
    """The zone under a ground sensor."""

    id: ReadingId
    tick: SampleTick | None = None
    zone: Word | None = None
    """Name of the first zone of the map that contains the point; absent means that the point is outside all zones."""


class BumperReading(Record, frozen=True, kw_only=True):
    """The state of a bumper."""

    id: ReadingId
    tick: SampleTick | None = None
    value: bool
    """Whether the body touches a wall or another body."""


class TruthReading(Record, frozen=True, kw_only=True):
    """The true pose and twist."""

    id: ReadingId
    tick: SampleTick | None = None
    x: MapX
    y: MapY
    heading: MapHeading
    speed: Velocity
    """True speed of the centre of movement, forward positive."""
    turn_rate: TurnRate
    """True rate of turn, positive anticlockwise."""


class Sensors(Record, frozen=True, kw_only=True):
    """Readings, grouped by the kind of sensor."""

    proximity: tuple[ProximityReading, ...] = ()
    """Distances from proximity sensors."""
    lidar: tuple[LidarReading, ...] = ()
    """Scans from range finders."""
    encoders: tuple[EncodersReading, ...] = ()
    """Counts of the wheels."""
    odometry: tuple[OdometryReading, ...] = ()
    """Poses by dead reckoning."""
    compass: tuple[CompassReading, ...] = ()
    """Headings from compasses."""
    gps: tuple[GPSReading, ...] = field(default=(), name="GPS")
    """Positions in the map frame."""
    imu: tuple[IMUReading, ...] = field(default=(), name="IMU")
    """Accelerations and turn rates."""
    beacon: tuple[BeaconReading, ...] = ()
    """Bearings of beacons."""
    ground: tuple[GroundReading, ...] = ()
    """Zones under ground sensors."""
    bumper: tuple[BumperReading, ...] = ()
    """States of bumpers."""
    truth: tuple[TruthReading, ...] = ()
    """True poses and twists, if the simulation allows them."""


class Heard(Record, frozen=True, kw_only=True):
    """A message that an agent received from another agent or an operator."""

    sender: Name = field(name="From")
    """Name of the agent that sent the message, or operator."""
    tick: Tick
    """Tick at which the message was sent."""
    seq: Count | None = None
    """Seq of the sender's message, if it had one."""
    distance: Range
    """Distance from the sender's position at sending to the receiver's centre of movement; 0 for an operator."""
    text: ContentText
    """Text of the message."""


class UserInput(Record, frozen=True, kw_only=True):
    """The input of a person who steers a robot.

    The motors get power 0 if no input arrives for 0.3 s of wall time, or of simulated time in strict lockstep.
    """

    lease: Hex | None = None
    """Lease from the Result of take; required while the robot is taken, absent otherwise."""
    seq: Count | None = None
    """Sender's message counter; an input with a Seq that is not higher than the last one is dropped."""
    forward: Power = 0.0
    """Stick forward and backward: 1 is full speed forward, -1 full speed backward."""
    turn: Power = 0.0
    """Stick sideways: 1 is full left (anticlockwise), -1 full right."""
    buttons: Annotated[tuple[Button, ...], Meta(max_length=64)] = ()
    """Numbers of the buttons that are pressed."""
    word: Word | None = None
    """A single command word, such as forward, left or stop."""
    goal: Goal | None = None
    """Pose that the person wants to reach."""


class Measures(Record, frozen=True, kw_only=True):
    """The sensor readings and messages of an agent after `Tick` steps."""

    run: Run
    tick: StateTick
    time: Time
    collision: bool = False
    """Whether an obstacle prevented the commanded motion in the last step."""
    contact: bool = False
    """Whether the body touches a wall or another body."""
    state: MotorState = "drive"
    """Whether the motors obey the agent's commands: drive means yes, any other state gives the reason why not."""
    sensors: Sensors | None = None
    """Readings of all sensors that report at this tick."""
    message: tuple[Heard, ...] = ()
    """Messages received at this tick, in the order in which they were sent."""
    user_input: UserInput | None = None
    """Latest input of the user, if the robot declares UserInput and an input has arrived."""


class AgentMeasures(Measures, frozen=True, kw_only=True):
    """The `Measures` of one agent of a crew."""

    agent: Name
    """Name of the agent that the measures are for."""


class CrewMeasures(Record, frozen=True, kw_only=True):
    """The `Measures` of many agents of one process."""

    crew: Name
    """Name of the crew, as in the key."""
    part: PartNumber = 0
    parts: PartCount = 1
    measures: Annotated[tuple[AgentMeasures, ...], Meta(max_length=250)] = ()
    """Measures of the crew's agents."""


class Pose(Record, frozen=True, kw_only=True):
    """The pose of a real robot, reported by its bridge."""

    run: SentRun | None = None
    session: SentSession | None = None
    tick: SentTick | None = None
    seq: SentSeq | None = None
    x: MapX
    y: MapY
    heading: MapHeading
    stamp: Stamp | None = None
    """Unix time at which the pose was measured."""
    covariance: tuple[Variance, ...] = ()
    """Covariance of X, Y and Heading (h): xx xy xh yy yh hh, in m2, m rad and rad2; 6 numbers or none."""
    sensors: Sensors | None = None
    """Readings of the robot's sensors that are declared with Source real."""
    code: Code | None = None


class PowerInForce(Record, frozen=True, kw_only=True):
    """The power that a real robot must apply now, and the reason."""

    run: Run
    tick: StateTick
    left_motor: Power
    """Power of the left motor to apply, positive forward."""
    right_motor: Power
    """Power of the right motor to apply, positive forward."""
    state: MotorState = "drive"
    """Source of the power: drive (the mind) or taken (an operator). In any other state the power is 0."""
    seq: Count | None = None
    """Counter of the powers for this key. A bridge drops a power whose Seq is not higher than the last one."""
    code: Code | None = None


class Error(Record, frozen=True, kw_only=True):
    """An error in a message that an agent sent."""

    run: Run
    tick: StateTick
    code: ErrorCode
    """Reason, for programs."""
    where: Title | None = None
    """Place of the error in the document, such as Actions.LeftMotor."""
    seq: Count | None = None
    """Seq of the wrong message, if it could be read."""
    suppressed: Count = 0
    """Number of errors that the rate limit suppressed since the last Error message."""
    text: ContentText
    """Reason, for people: the place, what was expected and what was received."""


class CrewError(Error, frozen=True, kw_only=True):
    """An error in a message that a crew sent."""

    agent: Name | None = None
    """Agent that the error is about; absent means the whole message."""


# ---------------------------------------------------------------- the world, for viewers


class Entity(Record, frozen=True, kw_only=True):
    """The true state of one body."""

    name: AgentName
    x: MapX
    y: MapY
    heading: MapHeading
    speed: Velocity = 0.0
    """Speed of the centre of movement, forward positive: the mean over the last tick."""
    turn_rate: TurnRate = 0.0
    """Rate of turn, positive anticlockwise: the mean over the last tick."""
    left_output: Power = 0.0
    """Output of the left motor at the end of the last tick, equation (1) of the IntellWheels Simulator paper (2009),
    positive forward."""
    right_output: Power = 0.0
    """Output of the right motor at the end of the last tick, equation (1) of the IntellWheels Simulator paper (2009),
    positive forward."""
    collision: bool = False
    """Whether an obstacle prevented the commanded motion in the last step."""
    contact: bool = False
    """Whether the body touches a wall or another body."""
    contacts: Count = 0
    """Number of contact episodes since the start of the run; touching again within 0.25 s counts as the same one."""
    state: MotorState = "drive"
    """Whether the motors obey the mind's commands: drive means yes, any other state gives the reason why not."""
    mode: Word | None = None
    """What the mind says it is doing, from its Actions."""
    goal: Goal | None = None
    """Where the mind says it is going, from its Actions."""
    say: ElementText | None = None
    """Last message that the agent sent, shown for 3 s of simulated time."""
    command_age: Seconds = 0.0
    """Mean time from the Measures to the effect of the commands that answer them; 0 means less than half a tick."""
    travelled: Travel | None = None
    """Distance that the body has travelled in the run, without moves by an operator; absent in a playback."""
    turned: Turned | None = None
    """Largest angle from the first heading of the body in the run, up to pi; absent in a playback."""


class WorldState(Record, frozen=True, kw_only=True):
    """The true state of every body, split into parts of at most 48 kB."""

    run: Run
    tick: StateTick
    time: Time
    part: PartNumber = 0
    parts: PartCount = 1
    entity: tuple[Entity, ...] = ()
    """Bodies in the order of their names; a body that is in none of the parts does not exist any more."""


class Body(Record, frozen=True, kw_only=True):
    """A body as the simulator accepted it, for viewers and late joiners."""

    run: Run
    tick: StateTick
    owner: Hex | None = None
    """Instance of the process that joined with this body; absent if the simulator owns it."""
    roles: tuple[Role, ...] = ()
    """Roles in which processes have joined this body."""
    robot: Robot
    """Shape, motors and sensors, as the simulator accepted them."""


class Event(Record, frozen=True, kw_only=True):
    """An event in a run. Events are numbered, so that a reader can detect gaps."""

    run: Run
    tick: StateTick
    number: Count
    """Number of the event, counted from 0 in each run without gaps."""
    code: EventCode
    """What happened, for programs."""
    agent: Name | None = None
    """Agent that the event is about; in a contact, the agent that ran into the other body."""
    other: Word | None = None
    """Of a contact: name of the other body, or the word wall."""
    part: Count | None = None
    """Of a contact: index of the agent's Part that touched, from 0."""
    other_part: Count | None = None
    """Of a contact: index of the other body's Part, or of the Wall in the map, from 0."""
    x: Coordinate | None = None
    """Of a contact: x coordinate of the contact point in the map frame."""
    y: Coordinate | None = None
    """Of a contact: y coordinate of the contact point in the map frame."""
    normal_x: Normal | None = None
    """Of a contact: x of the unit normal in the map frame, from the other body towards the agent."""
    normal_y: Normal | None = None
    """Of a contact: y of the unit normal in the map frame, from the other body towards the agent."""
    speed: Velocity | None = None
    """Closing speed along the normal at a contact, positive when approaching. In an event speed, the new factor."""
    text: OptionalText | None = None
    """Details for people, if there are any."""


class Events(Record, frozen=True, kw_only=True):
    """The events that the simulator still keeps, from a requested number on."""

    run: Run
    oldest: Count
    """Number of the oldest event that is kept; earlier ones are lost."""
    next: Count
    """Number for the next request: one more than that of the last event in this reply."""
    event: tuple[Event, ...] = ()
    """Events in the order of their numbers."""


class Clock(Record, frozen=True, kw_only=True):
    """The simulated time of a run, and its speed."""

    run: Run
    tick: StateTick
    time: Time
    state: ClockState
    """State of the run: waiting (for agents), running, paused or ended (by its end condition)."""
    pace: Pace
    """How time passes: realtime, free (as fast as possible) or lockstep (waits for every member of the barrier)."""
    speed: Factor = 1.0
    """Requested speed: simulated time divided by wall time."""
    factor: Ratio = 0.0
    """Measured speed: simulated time divided by wall time; 0 if unknown."""
    late: Count = 0
    """Number of ticks of this run that started after their deadline."""
    load: Ratio = 0.0
    """Share of the last second of wall time in which the simulator was busy; ticks are late when it nears 1."""
    world: Ratio = 0.0
    """Part of Load that went into the world: steps and sensors; 0 in a log that is played."""
    wire: Ratio = 0.0
    """Part of Load that went into messages and all else; 0 in a log that is played."""
    rays: Count = 0
    """Rays per tick of the sensors of all bodies; a cone counts as several rays."""
    costliest: Name | None = None
    """Agent whose sensors cast the most rays; absent if no sensor casts any."""
    flooding: Name | None = None
    """Agent or crew that exceeded its message limit by the most in the last second; absent if none did."""
    hash: Kept
    stamp: Stamp
    """Unix time at which the message was written."""
    waiting: tuple[Name, ...] = ()
    """Agents whose answers the run is waiting for."""
    last: Tick | None = None
    """Last tick of this run in a log that is played; absent in a live run."""


class MapInfo(Record, frozen=True, kw_only=True):
    """The name of the loaded map. The reply to a `get` is the map itself."""

    run: Run
    tick: StateTick
    name: Word
    """Name of the map."""
    revision: Count
    """Number of times the map was replaced since the simulator started."""
    hash: Hex
    """Hash of the map's content."""


# ---------------------------------------------------------------- control


class Reach(Record, frozen=True, kw_only=True):
    """A condition: the agent's centre of movement is near a place."""

    agent: Name
    """Agent that must reach the place."""
    place: Word
    """Name of a Position in the map's Grid."""
    within: Size
    """Largest distance from the place that counts as reached."""


class Timeout(Record, frozen=True, kw_only=True):
    """A condition: a simulated time has passed."""

    seconds: Annotated[float, Meta(gt=0.0, le=1e9, extra=_unit("s"))]
    """Simulated time since the start of the run."""


class End(Record, frozen=True, kw_only=True):
    """The end condition of a run: every `Reach` is met, or the `Timeout` has passed."""

    reach: tuple[Reach, ...] = ()
    """Places that must be reached, all at the same tick."""
    timeout: Timeout | None = None
    """Longest duration of the run; absent means no limit."""


class Pause(Record, frozen=True, kw_only=True):
    """Stop simulated time. Steps in progress end, and their request gets `incorrect-state`."""


class Resume(Record, frozen=True, kw_only=True):
    """Let simulated time continue."""


class Step(Record, frozen=True, kw_only=True):
    """Make a number of steps in a paused run, then pause again."""

    count: Annotated[int, Meta(ge=1, le=1_000_000)] = 1
    """Number of steps to make."""


class Reset(Record, frozen=True, kw_only=True):
    """Start a new run on the same map, with the same agents at their start poses."""

    seed: NewSeed | None = None
    end: End | None = None
    """End condition of the new run; absent keeps the current one."""


class Speed(Record, frozen=True, kw_only=True):
    """Set the speed of a real-time run."""

    factor: Factor
    """Requested speed: simulated time divided by wall time; 1 is real time."""


class Delete(Record, frozen=True, kw_only=True):
    """Remove a body."""

    agent: Name | None = None
    """Agent whose body is removed, as in the key; absent means that of the key."""


class Take(Record, frozen=True, kw_only=True):
    """Take control of a body: the simulator obeys `user/<agent>` instead of the mind until the lease ends."""

    agent: Name | None = None
    """Agent whose body is taken, as in the key; absent means that of the key."""
    lease: Hex | None = None
    """Lease to renew or to end, from the Result of the first take; absent requests a new lease."""
    seconds: Annotated[float, Meta(ge=0.0, le=60.0, extra=_unit("s"))] = 2.0
    """Wall time after which the lease ends if it is not renewed; 0 ends it at once."""


class OperatorSay(Record, frozen=True, kw_only=True):
    """A message from an operator to one agent or to all."""

    to: Name | None = None
    """Agent that receives the message, at any distance; absent means all agents."""
    text: ContentText
    """Text of the message."""


class Save(Record, frozen=True, kw_only=True):
    """Save the state of the world; the reply names the slot."""


class Restore(Record, frozen=True, kw_only=True):
    """Return to a saved state, at its tick, as a new run."""

    slot: Word
    """Slot from the Result of save."""


class Seek(Record, frozen=True, kw_only=True):
    """Jump to a tick of a log that is played."""

    tick: Tick
    """Tick to show."""
    run: Hex | None = None
    """Run of the log; absent means the current run."""


class Quit(Record, frozen=True, kw_only=True):
    """Stop the simulator."""


class Spawn(Record, frozen=True, kw_only=True):
    """Add a body without a mind, owned by the simulator."""

    robot: Robot
    """Body to add; its Name is the name of the new agent."""
    position: Position | None = None
    """Start pose; absent means the robot's Place or Position, or the first free place for its Kind."""


class Teleport(Record, frozen=True, kw_only=True):
    """Move a body to another pose."""

    agent: Name | None = None
    """Agent whose body is moved, as in the key; absent means that of the key."""
    position: Position
    """New pose of the body, within the outer walls of the map like Robot.Position."""


class Result(Record, frozen=True, kw_only=True):
    """The reply to a control verb or a leave."""

    code: ResultCode
    """Outcome, for programs."""
    run: Run | None = None
    tick: StateTick | None = None
    hash: Kept | None = None
    lease: Hex | None = None
    """Lease that take granted. Send it with UserInput."""
    slot: Word | None = None
    """Slot in which save stored the state, for restore."""
    text: OptionalText | None = None
    """Reason, for people, if the request failed."""


# ---------------------------------------------------------------- files


class Wall(Record, frozen=True, kw_only=True):
    """A wall: a solid polygon, or with `Thickness` a line of at least 2 corners."""

    height: Size = 2.5
    """Height of the upper edge above the floor (not above Bottom)."""
    bottom: Length = 0.0
    """Height of the lower edge above the floor; more than 0 leaves a gap below."""
    thickness: Size | None = None
    """Thickness of a wall that is drawn as a line, half to each side; absent means a solid polygon."""
    corner: tuple[Corner, ...] = ()
    """Corners in order: at least 3 for a polygon, whose last corner is connected to the first, or 2 for a line."""


class Door(Record, frozen=True, kw_only=True):
    """The door of a doorway. Left and right are as seen along the heading of the doorway."""

    kind: DoorKind = "hinged"
    """How it opens: one leaf on a hinge, two leaves on hinges, one sliding leaf, or two sliding leaves."""
    side: Side = "left"
    """Jamb at which the hinge of a single leaf is, or to which a single leaf slides."""
    swing_deg: Degrees = 90.0
    """Angle of a full opening; positive opens along the heading of the doorway, negative against it."""


class Doorway(Record, frozen=True, kw_only=True):
    """An opening between walls that bodies can pass."""

    name: Word
    """Name of the doorway, unique in the map."""
    x: MapX
    y: MapY
    heading_deg: Degrees
    """Direction of passage in the map frame: 0 along x, positive anticlockwise."""
    width: Size
    """Clear width of the opening."""
    door: Door | None = None
    """Door in the opening; absent means that it is not known or that there is none."""


class Obstacle(Record, frozen=True, kw_only=True):
    """A named solid that is not a wall, such as a bed or a cupboard."""

    name: Word
    """Name of the obstacle, unique in the map."""
    bottom: Length = 0.0
    """Height of the lower face above the floor."""
    top: Size
    """Height of the upper face above the floor; must be more than Bottom."""
    corner: tuple[Corner, ...] = ()
    """Corners of its outline in order, at least 3."""


class Zone(Record, frozen=True, kw_only=True):
    """A named area of the map."""

    name: Word
    """Name of the zone, as ground sensors report it."""
    title: Title | None = None
    """Name of the zone for people."""
    corner: tuple[Corner, ...] = ()
    """Corners of its outline in order, at least 3."""


class Place(Record, frozen=True, kw_only=True):
    """A named pose on the map. Its element is `<Position>`."""

    name: Word
    """Name of the place, for Robot.Place, Reach and Beacon."""
    x: MapX
    y: MapY
    heading_deg: Degrees = 0.0
    """Heading of a body that starts here, in the map frame: 0 along x, positive anticlockwise."""
    kinds: tuple[Word, ...] = ()
    """Kinds of robot that may start here without naming this place; none means any kind."""


class Grid(Record, frozen=True, kw_only=True):
    """The named places of a map."""

    position: tuple[Place, ...] = ()
    """Places, in the order in which they are assigned to robots that name no place."""


class Route(Record, frozen=True, kw_only=True):
    """A way between named places that the author of the map drew, such as a lane for robots."""

    name: Word
    """Name of the route, unique in the map."""
    places: tuple[Word, ...] = ()
    """Names of the places along it in order, at least 2."""
    one_way: bool = False
    """Whether the route is for one direction only, that of its places."""


class SiteOffset(Record, frozen=True, kw_only=True):
    """The origin of the map frame in the coordinates of the site. The axes of both are parallel."""

    x: SiteCoordinate
    """Easting of the origin in metres; its longitude in degrees if Epsg is EPSG:4326."""
    y: SiteCoordinate
    """Northing of the origin in metres; its latitude in degrees if Epsg is EPSG:4326."""
    epsg: Title | None = None
    """Coordinate reference system of X and Y as text, such as EPSG:3763; absent means that it is not known."""


class Map(Record, frozen=True, kw_only=True):
    """A map: walls, doorways, obstacles, zones and named places."""

    format: Format
    name: Word
    """Name of the map."""
    title: Title | None = None
    """Name of the map for people."""
    source: Title | None = None
    """Source of the dimensions."""
    wall: tuple[Wall, ...] = ()
    """Walls, which stop bodies and block sensors."""
    doorway: tuple[Doorway, ...] = ()
    """Openings, for minds that plan a path."""
    obstacle: tuple[Obstacle, ...] = ()
    """Solids other than walls, which stop bodies and block sensors."""
    zone: tuple[Zone, ...] = ()
    """Areas for ground sensors; where two overlap the first one counts."""
    grid: Grid | None = None
    """Named places to start at, to reach or to sense."""
    route: tuple[Route, ...] = ()
    """Ways between the places, as the author of the map drew them."""
    offset: SiteOffset | None = None
    """Origin of the map frame in the coordinates of the site; absent means that the two frames are the same."""


class Load(Record, frozen=True, kw_only=True):
    """Start a new run on another map: an included one with `Name`, or the document in `Map`."""

    name: Word | None = None
    """Name of an included map; either this or Map."""
    seed: NewSeed | None = None
    map: Map | None = None
    """Map to load; either this or Name."""
    end: End | None = None
    """End condition of the new run; absent keeps the current one."""


class Option(Record, frozen=True, kw_only=True):
    """An option of a mind, a robot or a bridge."""

    name: Word
    """Name of the option; with a capital first letter it sets a field of the Robot instead."""
    value: OptionValue


class Cast(Record, frozen=True, kw_only=True):
    """An agent of a scene: its name, body, mind and start."""

    name: AgentName
    robot: Title = ""
    """Body of the agent: the name of an included robot, or the path of a robot file; empty means the mind's own."""
    mind: Title = ""
    """Mind of the agent: the name of an included mind, or the path of a Python file."""
    place: Word | None = None
    """Place on the map to start at; absent means the first free place for its Kind."""
    option: tuple[Option, ...] = ()
    """Options of the mind; an option with a capital first letter sets a field of the robot."""
    command: CommandLine | None = None
    """Command line of any program that plays the agent, in place of a Mind; the program brings its own body."""
    folder: Title | None = None
    """Folder where the program of Command starts; absent means the folder of the scene."""
    new_run: NewRun = "follow"
    """What a program does when a new run begins: it follows the new Run, or it is ended and started again."""


class Hold(Record, frozen=True, kw_only=True):
    """The conditions for success, checked at the end of a run."""

    contacts: Count | None = None
    """Largest number of contacts allowed; absent means any."""
    reached: Literal["all"] | None = None
    """Whether every Reach of the End must have been met; absent means not checked."""


class Setting(Record, frozen=True, kw_only=True):
    """An option that a level of an experiment sets."""

    agent: Name | None = None
    """Agent that gets the option; absent means a setting of the simulation, such as SayRange."""
    name: Word
    """Name of the option or setting."""
    value: OptionValue


class Uniform(Record, frozen=True, kw_only=True):
    """A number that differs from seed to seed: a uniformly distributed offset is added to it.

    It belongs to an option of an agent, to a named place or to an obstacle of the map. Rows that draw the same number
    draw the same offset for a seed, so that they can be compared seed by seed.
    """

    agent: Name | None = None
    """Agent whose option it is; the agent, or its Bridge, must have the option."""
    place: Word | None = None
    """Place of the map that is moved or turned."""
    obstacle: Word | None = None
    """Obstacle of the map that is moved."""
    name: Word
    """Name of the option; X or Y of a place or an obstacle in m, or HeadingDeg of a place."""
    low: Offset
    """Least offset, in the unit of the number."""
    high: Offset
    """Largest offset, more than Low."""
    follows: Word | None = None
    """Name of another Uniform option of this agent, whose offset is added to this number as well: so a calibration can
    follow the wheel that it measures."""


class Bridge(Record, frozen=True, kw_only=True):
    """A real chair for one agent of the cast. A second simulation of the same map, the laboratory, simulates it.

    A Bridge in a scene applies to every run. A Bridge in a level applies only to rows with that level, and replaces the
    scene's Bridge for the same agent. An option with a capital first letter sets a field of the real chair. Any other
    is an option of `iw-bridge`.
    """

    agent: Name
    """Agent of the cast whose chair is real."""
    chair: Title | None = None
    """Robot file of the real chair; absent means the robot of the cast."""
    option: tuple[Option, ...] = ()
    """Options of the bridge; an option with a capital first letter sets a field of the chair."""


class Level(Record, frozen=True, kw_only=True):
    """One value of a factor: agents that are replaced or added, and options that are set."""

    name: Word
    """Name of the level, used in the names of rows."""
    title: Title | None = None
    """Name of the level in reports."""
    real: bool = False
    """Whether the chair represents a real one, so that its contacts count as physical."""
    cast: tuple[Cast, ...] = ()
    """Agents of this level; an agent with the same name as one of the scene replaces it."""
    bridge: tuple[Bridge, ...] = ()
    """Real chairs of this level."""
    setting: tuple[Setting, ...] = ()
    """Options that this level sets."""
    uniform: tuple[Uniform, ...] = ()
    """Numbers that differ from seed to seed in rows with this level."""


class Varied(Record, frozen=True, kw_only=True):
    """A factor of an experiment. Its element is `<Factor>`."""

    name: Word
    """Name of the factor."""
    title: Title | None = None
    """Name of the factor in reports."""
    level: tuple[Level, ...] = ()
    """Values that the factor takes, at least one."""


class Compare(Record, frozen=True, kw_only=True):
    """A comparison of two rows, seed by seed, or a claim about one row."""

    first: Title
    """First row, which the expectation is about."""
    second: Title | None = None
    """Row that the first is compared with; absent only for collision-free."""
    expect: Literal["better", "worse", "equivalent", "collision-free"] | None = None
    """Expected result of the first row; absent means that the report shows only the difference."""


class Umbmark(Record, frozen=True, kw_only=True):
    """A UMBmark test: two rows whose chairs drive a square by odometry. Their end positions give the wheel figures."""

    left: Title
    """Row with the squares driven to the left (anticlockwise)."""
    right: Title
    """Row with the squares driven to the right (clockwise)."""
    side: Size
    """Length of a side of the square."""


class Experiment(Record, frozen=True, kw_only=True):
    """Variations of a scene to run and compare. Every combination of levels is a row, named `first+second`."""

    subject: Name
    """Agent whose runs are measured."""
    margin: Share = 0.15
    """Largest difference of success rates at which two rows are equivalent."""
    factor: tuple[Varied, ...] = ()
    """Factors that are varied."""
    uniform: tuple[Uniform, ...] = ()
    """Numbers that differ from seed to seed, in all rows."""
    compare: tuple[Compare, ...] = ()
    """Comparisons that the report makes."""
    umbmark: Umbmark | None = None
    """Rows to be evaluated as a UMBmark test, if any."""


class Scene(Record, frozen=True, kw_only=True):
    """A run to start: map, agents, pace, end condition and conditions for success."""

    format: Format
    name: Word
    """Name of the scene."""
    title: Title | None = None
    """Name of the scene for people."""
    map: Title
    """Map: the name of an included map, or the path of a map file."""
    seed: Seed = defaults.SEED
    """Seed of all noise in the run."""
    period: Period = defaults.PERIOD
    pace: Pace = "lockstep"
    """How time passes: realtime, free (as fast as possible) or lockstep (waits for every member of the barrier)."""
    miss: Miss = "strict"
    """What a missed deadline does in lockstep: strict ends the run, elastic continues without the answer."""
    truth: bool = False
    """Whether agents may have truth sensors."""
    say_range: SayRange = defaults.SAY_RANGE
    """Largest distance between the sender and a receiver of a message."""
    say_walls: bool = defaults.SAY_WALLS
    """Whether walls and closed doors block messages."""
    say_loss: Share = defaults.SAY_LOSS
    """Share of messages between agents that a receiver misses."""
    say_delay: SayDelay = defaults.SAY_DELAY
    """Simulated time by which a message is delayed, in addition to one tick."""
    cast: tuple[Cast, ...] = ()
    """Agents to start."""
    bridge: tuple[Bridge, ...] = ()
    """Real chairs among the cast."""
    end: End | None = None
    """End condition; absent means that the run does not end by itself."""
    hold: Hold | None = None
    """Conditions for success; absent means none."""
    experiment: Experiment | None = None
    """Variations of the scene to run and compare, if any."""


class May(Record, frozen=True, kw_only=True):
    """What an identity may do in one world."""

    role: LabRole
    """Kind of program: `Who may do what` in KEYS.md lists what each may read and write."""
    world: Name = defaults.WORLD
    """World in which it may do so."""
    agents: Annotated[tuple[NamePattern, ...], Meta(max_length=64)] = ()
    """Agents that it may be, steer or change: names, beginnings such as st1-*, or * for all. The roles agent, mind and
    bridge require them; simulator and recorder have none."""
    verbs: Annotated[tuple[ControlVerb, ...], Meta(max_length=32)] = ()
    """Of an operator: control verbs that it may ask for; none means all."""


class Identity(Record, frozen=True, kw_only=True):
    """A person or a program, with a password of its own."""

    name: Name
    """User name with which it connects to the router."""
    certificate: bool = False
    """Whether it must show a certificate besides its password, as for real chairs and open networks."""
    until: Date | None = None
    """Last day, in UTC, on which it may connect; absent means no end."""
    may: tuple[May, ...] = ()
    """Everything that it may do; what is not listed is denied."""


class Lab(Record, frozen=True, kw_only=True):
    """A lab: the people and programs that share a router, and what each of them may do."""

    format: Format
    name: Word
    """Name of the lab."""
    identity: tuple[Identity, ...] = ()
    """All people and programs that may connect."""


DOCUMENTS: Final[dict[str, tuple[type[Record], ...]]] = {
    "Robot": (Robot,), "Joined": (Joined,), "Refused": (Refused,), "Leave": (Leave,), "Actions": (Actions,),
    "CrewJoin": (CrewJoin,), "CrewJoined": (CrewJoined,), "CrewLeave": (CrewLeave,), "CrewActions": (CrewActions,),
    "CrewMeasures": (CrewMeasures,), "CrewError": (CrewError,), "Say": (Say, OperatorSay), "Measures": (Measures,),
    "Pose": (Pose,), "Power": (PowerInForce,), "UserInput": (UserInput,), "Error": (Error,),
    "WorldState": (WorldState,), "Body": (Body,), "Event": (Event,), "Events": (Events,), "Clock": (Clock,),
    "MapInfo": (MapInfo,), "Map": (Map,), "Scene": (Scene,), "Lab": (Lab,), "Result": (Result,), "Pause": (Pause,),
    "Resume": (Resume,), "Step": (Step,), "Reset": (Reset,), "Load": (Load,), "Speed": (Speed,), "Spawn": (Spawn,),
    "Delete": (Delete,), "Teleport": (Teleport,), "Take": (Take,), "Save": (Save,), "Restore": (Restore,),
    "Seek": (Seek,), "Quit": (Quit,),
}  # fmt: skip
"""The documents by the name of their XML root; where two share one, the key decides."""

ROOTS: Final[dict[type[Record], str]] = {kind: root for root, kinds in DOCUMENTS.items() for kind in kinds}
"""The XML root of each document class."""

REFUSED_CODES: Final[tuple[str, ...]] = get_args(RefusedCode)
ERROR_CODES: Final[tuple[str, ...]] = get_args(ErrorCode)
EVENT_CODES: Final[tuple[str, ...]] = get_args(EventCode)
RESULT_CODES: Final[tuple[str, ...]] = get_args(ResultCode)
