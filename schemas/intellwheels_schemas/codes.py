"""The meaning of each code, and the corresponding ROS services and codes. Data for KEYS.md."""

from __future__ import annotations

from typing import Final, NamedTuple

from intellwheels_schemas.messages import ErrorCode, EventCode, MotorState, RefusedCode, ResultCode

REFUSED: Final[dict[RefusedCode, str]] = {
    "already-here": "another process has this role (its token exists), and the query did not give its Session",
    "no-token": "the liveliness token of this instance was not found: declare it first, or try again after a moment",
    "no-body": "a mind joined before its body did: try again every second",
    "no-place": "the map has no such place, or no free place for this Kind that is not kept for another agent",
    "overlaps": "the body would overlap something there, or a place that is kept for another agent",
    "name": "the name is invalid, reserved, or not the one in the key",
    "field": "an unknown, missing or misplaced field",
    "value": "a value outside its type or range, or bytes that cannot be read",
    "limit": "too many or too long",
    "version": "a version or an encoding that this simulator does not know",
    "truth": "a truth sensor in a simulation that does not allow it",
    "mount": "a sensor with Mount start on a real robot",
    "real-in-lockstep": "real hardware in lockstep or at a speed other than 1",
    "full": "there is no room for another body",
}

ERROR: Final[dict[ErrorCode, str]] = {
    "malformed": "bytes that are not JSON or XML, the wrong root element, or a name that occurs twice",
    "encoding": "an unknown encoding",
    "version": "a version that is not iw.v1",
    "field": "an unknown, missing or misplaced field, or an unknown key",
    "value": "a value outside its type or range",
    "too-long": "more bytes or characters than the limit",
    "too-many": "more items than the limit, or more messages than the simulator accepts",
    "late": "the tick ended too long ago; the message was dropped",
    "early": "the tick has not started yet; the message was dropped",
    "answered": "a member of the barrier sent two different answers to one tick; the second one was dropped",
    "session": "the Session is old or belongs to another process; the message was dropped",
    "lease": "user input without the current lease; the message was dropped",
    "not-joined": "the sender has not joined; the message was dropped",
    "role": "this role may not send that; the message was dropped",
    "deleted": "an operator deleted the body of the agent, which must not join again by itself",
    "forged": "the Code of a Pose was not made with the key of the bridge; the message was dropped",
}

EVENT: Final[dict[EventCode, str]] = {
    "joined": "an agent joined",
    "left": "an agent left",
    "lost": "the token of an agent disappeared and did not return within the grace time",
    "returned": "the token of an agent came back within the grace time",
    "contact": "a contact started",
    "parted": "a contact ended: no touch for 0.25 s of simulated time",
    "stale": "the pose of a real robot is too old, so its power is 0",
    "fresh": "a real robot reports its pose again",
    "late": "a member of the barrier missed a deadline",
    "rested": "a member of the barrier missed three deadlines in a row: power 0 until it answers again",
    "back": "a rested member of the barrier answers again",
    "timeout": "no motor command for longer than the command time-out: power 0",
    "taken": "an operator took control of a body",
    "released": "an operator returned control of a body, or the lease expired",
    "spawned": "an operator added a body",
    "deleted": "an operator removed a body",
    "teleported": "an operator moved a body",
    "paused": "simulated time was stopped",
    "resumed": "simulated time continues",
    "speed": "the speed was changed",
    "reset": "a new run started on the same map",
    "loaded": "a new run started on another map",
    "ended": "the end condition was met",
}

MOTOR_STATE: Final[dict[MotorState, str]] = {
    "drive": "the motors obey the mind",
    "timeout": "no motor command for longer than the command time-out: power 0",
    "rested": "the mind missed three deadlines in a row in lockstep: power 0 until it answers again",
    "paused": "a real robot stands still because of a pause, or of a speed other than 1: power 0",
    "taken": "an operator has taken control: the motors obey `user/<agent>`",
    "stale": "the pose of a real robot is too old: power 0 until it reports again",
}

RESULT: Final[dict[ResultCode, str]] = {
    "ok": "done",
    "unsupported": "this simulator does not support the request",
    "not-found": "the requested agent, map, slot or tick does not exist",
    "incorrect-state": "the request is not possible in the current state",
    "failed": "the request was tried and failed; Text gives the reason",
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
    "step": Ros("StepSimulation, SimulateSteps", "steps = Count; the simulation must be paused"),
    "reset": Ros("ResetSimulation", "scope is everything, including simulated time; agents stay joined"),
    "load": Ros("LoadWorld", "uri = Name, or resource_string = the Map as XML"),
    "speed": Ros("", "none"),
    "spawn": Ros("SpawnEntity", "name = Robot.Name, the Robot as its resource, initial_pose = Position"),
    "delete": Ros("DeleteEntity", "the entity's name = the agent in the key"),
    "teleport": Ros("SetEntityState", "the entity's name = the agent in the key, state.pose = Position"),
    "take": Ros("", "none"),
    "say": Ros("", "none"),
    "save": Ros("", "none"),
    "restore": Ros("", "none"),
    "seek": Ros("", "none"),
    "quit": Ros("SetSimulationState", "state QUITTING (3)"),
}

ROS_KEY: Final[dict[str, Ros]] = {
    "clock": Ros(
        "GetSimulationState", "STOPPED while waiting and after the end, PLAYING while running, PAUSED while paused"
    ),
    "state": Ros("GetEntitiesStates", "pose and twist of each Entity"),
    "body": Ros("GetEntities, GetEntityInfo", "category = Kind"),
    "map": Ros("GetCurrentWorld", "world.name = Name"),
}
