"""The rows of a state: the meaning of each number and flag of a body. The hash uses the same order.

Written with the module's name, `numbers[rows.SPEED, i]`, which numba compiles to the constant.
"""

# Rows of numbers, float64[NUMBER_ROWS, n]. The first eight are the block of bodies that sensors read, in their order.
X = 0
"""Centre of movement, m."""
Y = 1
"""Centre of movement, m."""
HEADING = 2
"""Heading in (-pi, pi], rad."""
SPEED = 3
"""Travel along the heading in the last tick over its period, m/s, within `MOST_SPEED`."""
TURN_RATE = 4
"""Turn in the last tick over its period, rad/s, within `MOST_TURN_RATE`."""
LEFT_TRAVEL = 5
"""Distance that the left wheel rolled since joining, m."""
RIGHT_TRAVEL = 6
"""Distance that the right wheel rolled since joining, m."""
TOUCHING = 7
"""1 where the body touched something in the last tick."""
LEFT_SPEED = 8
"""Speed of the left wheel after the lag, m/s."""
RIGHT_SPEED = 9
"""Speed of the right wheel after the lag, m/s."""
LEFT_COMMAND = 10
"""Power last commanded."""
RIGHT_COMMAND = 11
"""Power last commanded."""
LEFT_POWER = 12
"""Power in force, after time-out, rest, halt and take."""
RIGHT_POWER = 13
"""Power in force."""
USER_FORWARD = 14
"""Forward that the user wants, in [-1, 1]; 0 once the user is silent."""
USER_TURN = 15
"""Turn that the user wants, in [-1, 1], positive to the left."""
ALLOWED_PENETRATION = 16
"""Depth up to which the body may overlap something, because it was put there, m."""
NUMBER_ROWS = 17

WORLD_EDGE = 10_000.0
"""Largest coordinate on either axis that a message can carry, m."""
MOST_SPEED = 100.0
MOST_TURN_RATE = 1000.0
"""Bounds of the wire, m/s and rad/s: a real chair's pose may jump, and a short period makes any turn fast."""

# Rows of flags, int64[FLAG_ROWS, n].
COLLISION = 0
"""1 where the body could not make the motion it wanted in the last tick."""
CONTACTS = 1
"""Episodes of contact since the run began."""
COMMAND_AGE = 2
"""Steps since the last command."""
TIMED_OUT = 3
"""1 once the last command is older than the robot's time-out."""
RESTED = 4
"""1 while lockstep keeps the body at rest because of missed answers."""
HALTED = 5
"""1 while a real body must not move: paused, or not at real time."""
TAKEN = 6
"""1 while the simulator obeys the user's input."""
USER_AGE = 7
"""Steps since the user's last input."""
SILENT = 8
"""1 while there is no user's input."""
STALE = 9
"""1 while a real body's pose is too old."""
POSE_AGE = 10
"""Steps since a real body's last pose."""
FLAG_ROWS = 11

# Columns of episodes, int64[e, 3]: keys of the two bodies, -1 for the walls, and the last tick of contact.
WALL_KEY = -1
