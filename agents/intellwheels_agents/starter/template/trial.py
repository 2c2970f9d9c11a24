"""Tests of the mind. Each test starts a simulator and the chair as separate processes. Run the tests with `pytest`."""


def test_chair_crosses_the_room_without_contact(intellwheels):
    sim = intellwheels(scene="scene.xml")
    sim.cast()
    sim.run_until(lambda now: now["chair1"].x > 4.0, seconds=15.0)
    assert sim.contacts == []


def test_chair_turns_away_from_a_wall(intellwheels):
    sim = intellwheels(floor="corner", seed="2")
    sim.agent("chair1", mind="mind.py", robot="robot.xml", place="leader", power=0.4)
    sim.run_until(lambda now: abs(now["chair1"].heading) > 1.0, seconds=30.0)
    sim.run_for(5.0)
    assert sim.contacts == []


def test_chair_stops_when_its_mind_is_killed(intellwheels):
    sim = intellwheels(floor="corner", pace="realtime")
    sim.agent("chair1", mind="mind.py", robot="robot.xml", place="leader")
    sim.run_until(lambda now: now["chair1"].speed > 0.1, seconds=5.0)
    sim.kill("chair1")
    sim.run_until(lambda now: now["chair1"].speed < 0.01, seconds=3.0)
