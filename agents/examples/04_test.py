"""Lesson 4: tests. Each test starts a simulator and agents as separate processes, and ends them.

    pytest 04_test.py

In lockstep, the default, simulated time stops between the calls, and the same seed gives the same run on any machine.
`python -m pydoc intellwheels_experiments.testing.rig` shows all methods of `sim`.
"""


def test_chair_drives_around_the_hall_without_contact(intellwheels):
    sim = intellwheels(floor="square", seed="1")
    sim.agent("chair1", mind="02_sensors.py", robot="mid-wheel", place="start", power=0.5)
    sim.run_until(lambda now: now["chair1"].mode == "turning", seconds=15.0)
    sim.run_until(lambda now: now["chair1"].y > 3.0, seconds=30.0)
    assert sim.contacts == []


def test_door_opens_when_the_chair_asks(intellwheels):
    sim = intellwheels(floor="door", seed="1")
    door = {"swing": "right", "Proximity.MaxRange": "1"}
    sim.agent("door", mind="door", robot="door", place="hinge", **door)
    sim.agent("chair1", mind="03_say.py", robot="rear-wheel", place="start")
    sim.run_until(lambda now: now["chair1"].x > 8.0, seconds=40.0)
    assert sim.contacts == []


def test_chair_stops_when_its_mind_is_killed(intellwheels):
    sim = intellwheels(floor="square", pace="realtime")
    sim.agent("chair1", mind="02_sensors.py", robot="mid-wheel", place="start")
    sim.run_until(lambda now: now["chair1"].speed > 0.1)
    sim.kill("chair1")
    sim.run_until(lambda now: now["chair1"].speed < 0.01, seconds=3.0)
