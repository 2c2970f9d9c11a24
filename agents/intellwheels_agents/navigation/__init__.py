"""The parts of the mind `navigate`: free space, cost to go, motion window, what the sensors see, the pose.

These files need numpy, which the extra `navigate` installs. The mind imports them when it is made, so that agents
without it stay importable.
"""
