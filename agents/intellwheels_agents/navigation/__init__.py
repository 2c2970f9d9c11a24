"""The parts of the minds `navigate`, `aided` and `seek`: free space, cost to go, sight, collision checks.

These files need numpy, which the extra `navigate` installs. The minds import them when they are made, so that agents
without it stay importable.
"""
