"""What each code means, and which ROS service and code stands for what. Data for KEYS.md and for people."""

from __future__ import annotations

from typing import Final, NamedTuple

from intellwheels_schemas.messages import ErrorCode, EventCode, RefusedCode, ResultCode

REFUSED: Final[dict[RefusedCode, str]] = {
    "already-here": "a token of another instance of this role lives, and the old Session was not shown",
    "no-token": "the instance's own liveliness token is not there: declare it first",
    "no-body": "a mind came before its body: try again each second",
    "no-place": "no such place, or no free one for this Kind",
    "overlaps": "the place is taken",
    "name": "not a name, reserved, or not the name in the key",
    "field": "an unknown, missing or misplaced field",
    "value": "a value outside its type or range, or bytes that cannot be read",
    "limit": "too many or too long",
    "version": "a version or encoding this simulator does not speak",
    "truth": "a truth sensor where the simulation does not allow it",
    "mount": "Mount start on a real robot",
    "real-in-lockstep": "real hardware in lockstep or at a speed other than 1",
    "full": "no room for another body",
}

ERROR: Final[dict[ErrorCode, str]] = {
    "malformed": "bytes that are no JSON or XML, another root, or a name that comes twice",
    "encoding": "an encoding that is none of the contract's",
    "version": "a version that is not iw.v1",
    "field": "an unknown, missing or misplaced field",
    "value": "a value outside its type or range",
    "too-long": "more bytes or characters than the limit",
    "too-many": "more things than the limit, or more messages than the simulator takes",
    "late": "a tick that is over; dropped",
    "early": "a tick that has not come; dropped",
    "answered": "a second and different answer of a barrier member to one tick; dropped",
    "session": "another's or an old Session; dropped",
    "lease": "user input without the lease that runs; dropped",
    "not-joined": "from who has not joined; dropped",
    "role": "not this role's to send; dropped",
}

EVENT: Final[dict[EventCode, str]] = {
    "joined": "an agent joined in a role",
    "left": "an agent left",
    "lost": "an agent's token went and did not return within the grace time",
    "returned": "an agent's token came back within the grace time",
    "contact": "a contact began",
    "parted": "a contact ended: 0.25 s simulated without it",
    "stale": "a real chair's pose is older than it may be",
    "fresh": "a real chair reports again",
    "late": "a barrier member missed a deadline",
    "rested": "a barrier member missed three in a row: its body rests",
    "back": "a rested member answers again",
    "timeout": "no command for longer than the command time-out: power 0",
    "taken": "an operator took a body over",
    "released": "an operator gave a body back, or the lease ran out",
    "spawned": "a body was put in by an operator",
    "deleted": "a body was taken out by an operator",
    "teleported": "a body was put elsewhere by an operator",
    "paused": "time stands",
    "resumed": "time goes on",
    "speed": "another speed",
    "reset": "the run began anew",
    "loaded": "another floor",
    "ended": "the end condition is met",
}

RESULT: Final[dict[ResultCode, str]] = {
    "ok": "done",
    "unsupported": "this simulator cannot do that",
    "not-found": "no such agent, floor, slot or tick",
    "incorrect-state": "not now",
    "failed": "tried, and it did not work; Text says why",
}

ROS_RESULT: Final[dict[ResultCode, str]] = {
    "ok": "OK (1)",
    "unsupported": "FEATURE_UNSUPPORTED (0)",
    "not-found": "NOT_FOUND (2)",
    "incorrect-state": "INCORRECT_STATE (3)",
    "failed": "OPERATION_FAILED (4)",
}
"""The `result` of `simulation_interfaces/msg/Result` for each code of a `Result`."""


class Ros(NamedTuple):
    """The counterpart of a verb or key in ROS `simulation_interfaces`."""

    service: str
    how: str


ROS_VERB: Final[dict[str, Ros]] = {
    "pause": Ros("SetSimulationState", "state PAUSED (2)"),
    "resume": Ros("SetSimulationState", "state PLAYING (1)"),
    "step": Ros("StepSimulation, SimulateSteps", "steps = Count; needs a paused simulation"),
    "reset": Ros("ResetSimulation", "all of it, simulated time too; joins stay"),
    "load": Ros("LoadWorld", "uri = Name, or resource_string = the Map as XML"),
    "speed": Ros("", "none"),
    "spawn": Ros("SpawnEntity", "name = Robot.Name, the Robot as its resource, initial_pose = Position"),
    "delete": Ros("DeleteEntity", "the entity's name = Agent"),
    "teleport": Ros("SetEntityState", "the entity's name = Agent, state.pose = Position"),
    "take": Ros("", "none"),
    "say": Ros("", "none"),
    "save": Ros("", "none"),
    "restore": Ros("", "none"),
    "seek": Ros("", "none"),
    "quit": Ros("SetSimulationState", "state QUITTING (3)"),
}

ROS_KEY: Final[dict[str, Ros]] = {
    "clock": Ros("GetSimulationState", "STOPPED for waiting and ended, PLAYING for running, PAUSED for paused"),
    "state": Ros("GetEntitiesStates", "pose and twist of each Entity"),
    "body": Ros("GetEntities, GetEntityInfo", "category = Kind"),
    "map": Ros("GetCurrentWorld", "world.name = Name"),
}
