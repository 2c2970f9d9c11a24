"""Reports of faults, one row each: what it was about, our own small input, and the right value.

The first rows are the faults that were found in this project, by the number in their list. The others are about faults
that people reported of other simulators, robots and libraries: each could be ours too. `tests/test_reports.py` runs
every row. A row whose input needs processes or many lines names the test that holds it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from intellwheels_maps.check import check_map
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import Join, Restart
from intellwheels_schemas.messages import (
    Actions,
    Corner,
    Encoders,
    Lidar,
    Map,
    Proximity,
    Robot,
    Wall,
)
from intellwheels_server.world import State, apply, entities, measures
from tests.server.worlds import box_wall, cart, do, run, world


@dataclass(frozen=True)
class Report:
    """A fault that somebody reported.

    Attributes:
        about: What it was about, in our own words.
        case: Our input; returns the value that was wrong.
        right: The right value.
        held_by: The test that holds it, `tests/FILE.py::NAME`, instead of an input here.
        fault: Its number in this project's list of faults; empty for others.
    """

    about: str
    case: Callable[[], Any] | None = None
    right: Any = None
    held_by: str = ""
    fault: str = ""


def ours(fault: str, about: str, held_by: str) -> Report:
    """Return the row of a fault of this project."""
    return Report(about, held_by=f"tests/{held_by}", fault=fault)


# ---------------------------------------------------------------- small inputs


def refused(call: Callable[[], object]) -> str:
    """Return the text of the error that a call raises; empty if it raises none."""
    try:
        call()
    except WireError as error:
        return error.text
    return ""


def scan(lidar: dict[str, Any], *walls: Wall, **robots: Robot) -> tuple[Any, ...]:
    """Return the ranges of a lidar on a cart at the origin; a status stands for a range that is not ok."""
    known: dict[str, Any] = {"x": 0.0, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "fov_deg": 1.0, "rays": 1}
    made = Lidar(id="l", **{**known, "max_range": 8.0, **lidar})
    sensors = measures(world({"a": cart(lidar=(made,)), **robots}, walls), "a").sensors
    assert sensors is not None
    reading = sensors.lidar[0]
    statuses = reading.statuses or ("ok",) * len(reading.ranges)
    return tuple(status if one is None else one for one, status in zip(reading.ranges, statuses, strict=True))


def sonar(gap: float, **fields: Any) -> float | str | None:
    """Return what a proximity sensor at the front of a cart reads of a wall that is `gap` m away."""
    known: dict[str, Any] = {"x": 0.5, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 30.0, "max_range": 4.0}
    eye = Proximity(id="e", **{**known, **fields})
    sensors = measures(world({"a": cart(proximity=(eye,))}, [box_wall(0.5 + gap, -9.0, 20.0, 9.0)]), "a").sensors
    assert sensors is not None
    reading = sensors.proximity[0]
    return reading.status if reading.value is None else reading.value


def pose(state: State, name: str = "a") -> tuple[float, float, float]:
    body = next(one for one in entities(state) if one.name == name)
    return body.x, body.y, body.heading


def driven(
    robot: Robot, steps: int, left: float, right: float, *walls: Wall, **setup: Any
) -> tuple[float, float, float]:
    """Return where a robot is after some steps with the same powers."""
    state, _ = run(world({"a": robot}, walls, **setup), steps, {"a": (left, right)})
    return pose(state)


def counts(slip: float) -> tuple[int, int]:
    """Return the encoder counts of a cart that pushes a wall for a second."""
    robot = cart(slip=slip, encoders=(Encoders(id="e"),))
    state, _ = run(world({"a": robot}, [box_wall(0.5, -2.0, 1.0, 2.0)]), 20, {"a": (1.0, 1.0)})
    sensors = measures(state, "a").sensors
    assert sensors is not None
    return sensors.encoders[0].left, sensors.encoders[0].right


def backed_out() -> float:
    """Return how far a cart comes back in a second that was driven into a wall before."""
    walls = [box_wall(1.0, -2.0, 1.5, 2.0)]
    state, _ = run(world({"a": cart()}, walls), 40, {"a": (1.0, 1.0)})
    at = pose(state)[0]
    state, _ = run(state, 20, {"a": (-1.0, -1.0)})
    return at - pose(state)[0]


def touching() -> tuple[bool, bool]:
    """Return Collision and Contact of a cart that stands with its front exactly at a wall."""
    state, _ = run(world({"a": cart()}, [box_wall(0.5, -2.0, 1.0, 2.0)]), 5)
    got = measures(state, "a")
    return got.collision, got.contact


def silent() -> float:
    """Return how far a cart still goes whose program says nothing after a first command, from a second later on."""
    state, _ = run(world({"a": cart()}), 1, {"a": (1.0, 1.0)})
    state, _ = run(state, 20)
    at = pose(state)[0]
    state, _ = run(state, 100)
    return pose(state)[0] - at


def turned() -> list[bool]:
    """Return for each tick of two turns whether the heading is in (-pi, pi] and changes by the same angle."""
    state, found = world({"a": cart()}), []
    for _ in range(80):
        before = pose(state)[2]
        state, _ = run(state, 1, {"a": (-0.8, 0.8)})
        heading = pose(state)[2]
        step = math.remainder(heading - before, 2.0 * math.pi)
        found.append(-math.pi < heading <= math.pi and step == pytest.approx(0.16, abs=2e-6))
    return found


def met(*others: str) -> float:
    """Return where a cart stops in front of another one while others stand far away."""
    crowd = {name: cart(20.0 + 3.0 * index, 20.0) for index, name in enumerate(others)}
    state = world({"a": cart(), "b": cart(3.0), **crowd})
    return pose(run(state, 80, {"a": (1.0, 1.0)})[0])[0]


def time_after(ticks: int, period: float) -> float:
    return measures(run(world({"a": cart()}, period=period), ticks)[0], "a").time


def restarted() -> tuple[int, float, tuple[float, float, float]]:
    """Return tick, time and pose after a reset of a run."""
    state, _ = run(world({"a": cart()}), 30, {"a": (1.0, 0.5)})
    state, _ = apply(state, [Restart(run="fedcba9876543210", seed="1")])
    got = measures(state, "a")
    return got.tick, got.time, pose(state)


def faults_of_wall(*corners: tuple[float, float], thickness: float | None = 0.1) -> list[str]:
    wall = Wall(thickness=thickness, corner=tuple(Corner(x=x, y=y) for x, y in corners))
    return [finding.text for finding in check_map(Map(format="iw.v1", name="m", wall=(wall,)))]


SESSION = "c0ffee0012345678"


def actions_of(text: str) -> Callable[[], object]:
    return lambda: decode(Actions, text.encode(), Encoding.JSON)


def document_of(text: str) -> Callable[[], object]:
    return lambda: decode(Actions, text.encode(), Encoding.XML)


def mirrored() -> tuple[float, bool]:
    """Return how far the middle between two carts that met head-on is from 0, and whether both stand."""
    state = world({"a": cart(-2.0), "b": cart(2.0, heading=math.pi)})
    state, _ = run(state, 80, {"a": (1.0, 1.0), "b": (1.0, 1.0)})
    before = pose(state)[0] + pose(state, "b")[0]
    after, _ = run(state, 1, {"a": (1.0, 1.0), "b": (1.0, 1.0)})
    return round(before, 9), pose(after)[0] == pose(state)[0]


def touching_at(gap: float) -> str:
    """Return the answer to a cart that asks for a place in which it overlaps a wall."""
    _, outcome, _ = do(world(walls=[box_wall(gap, -2.0, 1.0, 2.0)]), Join(agent="a", robot=cart()))
    return "would overlap" if "would overlap" in (outcome.text or "") else f"{outcome.code}: {outcome.text}"


BALL = cart(length=0.05, width=0.05, top=0.1, track=0.05, top_speed=50.0)
PLATE = box_wall(2.5, -2.0, 2.52, 2.0)
SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
DRAWN = box_wall(1.0, -1.0, 2.0, 1.0), box_wall(-1.0, 1.0, 1.0, 2.0)
"""Two walls that share only the corner (1, 1)."""

REPORTS: list[Report] = [
    # ---------------------------------------------------------------- this project, found in use
    ours("S1", "ctl/pause answered ok while steps went on and motors drove",
         "server/service/test_control.py::test_pause_ends_running_steps_and_the_motors_of_a_real_chair_stand_at_once"),
    ours("S2", "two bridges of different names wrote to one serial line in turn",
         "e2e/test_bridge.py::test_a_second_bridge_on_the_same_line_is_refused_and_the_first_is_not_disturbed"),
    ours("S2", "a bridge wrote to its line before the simulator had let it in",
         "agents/bridge/test_serial_driver.py::test_nothing_is_written_before_the_simulator_has_accepted_the_bridge"),
    ours("S3", "two simulators that started together both served one world",
         "e2e/test_two_simulators.py::test_of_two_simulators_started_together_exactly_one_serves"),
    ours("S3", "a suspended simulator went on beside its successor",
         "e2e/test_two_simulators.py::test_a_simulator_that_wakes_up_beside_its_successor_ends"),
    ours("S4", "a run was held although the disk was full and its log was cut",
         "e2e/test_scenes.py::test_log_on_a_full_disk_fails_the_run"),
    ours("S4", "an edited log could not be told from one that was cut",
         "schemas/test_log_chain.py::test_lines_in_order_are_right_and_the_others_are_wrong"),
    ours("S5", "a wall of 2,500 corners stopped every tick for seconds",
         "e2e/test_costly_maps.py::test_world_goes_on_while_a_map_takes_longer_than_it_may"),
    ours("S5", "a polygon of 2,000 corners took minutes to load",
         "server/world/test_convex_pieces.py::test_two_thousand_corners_become_convex_pieces_that_cover_the_ring"),
    ours("S6", "one body with 64 lidars took a third of real time",
         "server/service/test_sensor_budget.py::test_body_with_too_many_rays_is_refused_in_words"),
    ours("S7", "bodies left while a router was away for a moment",
         "server/service/test_joining.py::test_token_that_returns_within_the_grace_time_changes_nothing"),
    ours("S7", "the counters of a serial line wrapped",
         "e2e/test_bridge.py::test_a_chair_whose_counters_wrap_drives_on_without_a_jump"),
    ours("S7", "a real chair drove on by itself after its simulator had been away",
         "e2e/test_bridge.py::test_after_the_return_of_the_simulator_a_person_says_go"),
    ours("1", "a scene could not name a program in another language",
         "experiments/run/test_foreign_program.py::test_program_starts_in_its_folder_with_its_values"),
    ours("2", "an agent whose answers were 60 ms late never drove",
         "server/service/test_command_ages.py::test_slow_agent_drives_and_the_mean_age_of_its_commands_is_shown"),
    ours("3", "KEYS.md and the code disagreed on what a query takes",
         "schemas/test_keys_page.py::test_what_a_query_takes_behind_its_key_stands_there"),
    ours("4", "schemas for readers refused fields that a reader must ignore",
         "schemas/test_reader_xsd.py::test_unknown_fields_pass_at_every_depth_and_known_ones_are_checked"),
    ours("5", "iw-check-agent let wrong agents pass",
         "experiments/conformance/test_main.py::test_one_fault_fails_its_point_and_no_other"),
    ours("6", "a mind that returned numbers of numpy ended with `unsupported type`",
         "agents/test_mind_run.py::test_numbers_of_other_libraries_are_numbers"),
    ours("6", "a mind without a return was noticed only by its silence",
         "agents/test_mind_run.py::test_wrong_answer_is_named_with_its_place"),
    ours("7", "a guest without a place took one that the cast needed",
         "maps/test_cast_places.py::test_agent_without_a_place_gets_the_first_for_its_kind_that_is_nobodys"),
    ours("8", "a scene had another hash with another C library",
         "e2e/test_same_hash.py::test_scenes_have_the_same_hashes_with_another_c_library"),
    ours("9", "--option and --mind of a single run had no effect",
         "e2e/test_scenes.py::test_changed_mind_and_options_count_in_a_single_run"),
    ours("10", "wrong options were found by a library, or after the run",
         "test_wrong_usage.py::test_wrong_values_of_every_option_are_one_line_each"),
    ours("10", "agents that start in one another were found when the second one joined",
         "maps/test_starts.py::test_bodies_in_one_another_are_found"),
    ours("10", "an endpoint without a protocol was answered with Zenoh's source",
         "schemas/test_endpoint_form.py::test_the_endpoint_that_was_meant_is_shown"),
    ours("11", "kernels were compiled in silence where the cache was of another Python",
         "server/world/test_warmup.py::test_compiling_is_announced_from_the_first_kernel_that_numba_compiles"),
    ours("11", "a first start on a loaded machine failed after 180 s",
         "experiments/run/test_start_watch.py::test_time_counts_from_the_last_words_and_each_kind_is_said_once"),
    ours("11", "iw-run at a router that nobody ran said nothing",
         "experiments/test_main.py::test_a_router_that_nobody_runs_is_waited_for_in_words"),
    ours("12", "an agent could not start at coordinates",
         "agents/test_main.py::test_a_chair_starts_at_coordinates"),
    Report("edges of less than a nanometre were valid, and the server crashed", fault="13",
           case=lambda: faults_of_wall((0.0, 0.0), (1e-10, 0.0), (1.0, 0.0)),
           right=["wall has corners less than 1e-09 m apart, X 0.0 Y 0.0"]),
    Report("a closed ring, whose last corner repeats its first, was refused", fault="13",
           case=lambda: faults_of_wall(*SQUARE, SQUARE[0], thickness=None), right=[]),
    Report("a small body passed a thin wall between two ticks", fault="14",
           case=lambda: driven(BALL, 20, 1.0, 1.0, PLATE)[0], right=pytest.approx(2.475, abs=1e-6)),
    ours("15", "the demo was over before anybody had opened its page",
         "e2e/test_view.py::test_a_scene_waits_for_its_page_and_runs_again_after_its_end"),
    ours("16", "a command that the page printed failed",
         "e2e/test_printed_commands.py::test_without_a_router_the_printed_command_starts_a_run_that_the_page_shows"),
    ours("16", "the page of a viewer that listens everywhere named no address",
         "viewer/panels/test_commands.py::"
         "test_who_joins_a_viewer_that_listens_everywhere_gets_an_address_to_connect_to"),
    ours("17", "the wedges of sensors on a door's frame turned with its leaf",
         "viewer/drawings/test_wedges.py::test_a_sensor_on_the_frame_of_a_door_stays_when_the_leaf_swings"),
    ours("18", "a drop could not be undone", "viewer/test_undo.py::test_the_newest_change_is_undone_first"),
    # ---------------------------------------------------------------- range sensors, elsewhere
    Report("a laser passed between two walls that share only a corner",
           lambda: scan({"direction_deg": 45.0}, *DRAWN), (pytest.approx(math.sqrt(2.0), abs=2e-6),)),
    Report("a laser passed through a box that was nearer than its least range",
           lambda: scan({"min_range": 0.5}, box_wall(0.6, -1.0, 0.7, 1.0), box_wall(3.0, -1.0, 4.0, 1.0)),
           (pytest.approx(0.6, abs=2e-6),)),
    Report("what is nearer than the least range was reported as free",
           lambda: scan({"min_range": 0.7}, box_wall(0.6, -1.0, 0.7, 1.0)), ("near",)),
    Report("no echo was reported as a very large number instead of as nothing",
           lambda: (sonar(9.0), scan({})), ("none", ("none",))),
    Report("a wall at exactly the greatest range was there in one tick and gone in the next",
           lambda: (sonar(4.0), sonar(4.0 + 1e-6)), (pytest.approx(4.0), "none")),
    Report("a wall that a ray runs along, edge-on, was a hit at a random distance",
           lambda: scan({}, box_wall(1.0, 0.5, 5.0, 1.0), box_wall(6.0, -1.0, 7.0, 1.0)), (pytest.approx(6.0),)),
    Report("a laser in the middle of its robot saw the robot itself",
           lambda: scan({"fov_deg": 360.0, "rays": 4}), ("none",) * 4),
    Report("a laser did not see other robots",
           lambda: scan({}, b=cart(3.0)), (pytest.approx(2.5),)),
    Report("a ray that looks backwards fell into the gap between -180 and 180 degrees",
           lambda: scan({"direction_deg": 180.0}, box_wall(-3.0, -1.0, -2.0, 1.0)), (pytest.approx(2.0),)),
    Report("a laser saw over a wall that is higher than the laser, or under a gate",
           lambda: scan({}, Wall(height=0.3, corner=box_wall(1, -1, 2, 1).corner),
                        Wall(height=2.0, bottom=0.5, corner=box_wall(2, -1, 3, 1).corner),
                        Wall(height=0.5, corner=box_wall(4, -1, 5, 1).corner)), (pytest.approx(4.0),)),
    # ---------------------------------------------------------------- contact and motion, elsewhere
    Report("a robot that had hit a wall could not back away", backed_out, pytest.approx(1.0, abs=0.01)),
    Report("a robot collided with something that is not there: it only touches a wall, at rest",
           touching, (False, False)),
    Report("whether two robots collide depended on how many others there are",
           lambda: met() == met(*(f"c{n}" for n in range(12))) == met("z"), True),
    Report("two robots that meet head-on did not stop at the same distance from the middle", mirrored, (0.0, True)),
    Report("a robot with equal powers drifted to a side", lambda: driven(cart(), 200, 0.7, 0.7)[1:], (0.0, 0.0)),
    Report("a robot that turns on the spot wandered off", lambda: driven(cart(), 200, -0.7, 0.7)[:2],
           (pytest.approx(0.0, abs=1e-12), pytest.approx(0.0, abs=1e-12))),
    Report("the heading jumped, and the robot spun, where the angle passes from pi to -pi", turned, [True] * 80),
    Report("a heading of -pi and one of pi were two poses",
           lambda: pose(world({"a": cart(heading=-math.pi)}))[2], math.pi),
    Report("a robot drove on for ever after its controller had died", silent, 0.0),
    Report("odometry went on while the wheels of a blocked robot stood", lambda: counts(0.0), (0, 0)),
    Report("odometry stood still while the wheels of a blocked robot spun",
           lambda: counts(1.0), (pytest.approx(1819, abs=2),) * 2),
    Report("a robot inside a wall could not be told from one that is free",
           lambda: touching_at(0.4), "would overlap"),
    # ---------------------------------------------------------------- time, elsewhere
    Report("simulated time drifted, because every tick added a rounded period",
           lambda: [time_after(1000, period) for period in (0.1, 0.05, 0.001)], [100.0, 50.0, 1.0]),
    Report("a reset kept the old time, or a body where it was", restarted, (0, 0.0, (0.0, 0.0, 0.0))),
    # ---------------------------------------------------------------- messages, elsewhere
    Report("a NaN as velocity turned the pose into NaN, or the wheels at full speed",
           lambda: [
               refused(actions_of(f'{{"Session": "{SESSION}", "LeftMotor": {value}}}')) != ""
               for value in ("NaN", "Infinity", "1e999")
           ],
           [True] * 3),
    Report("NaN came through in the other encoding",
           lambda: [
               refused(document_of(f'<Actions Session="{SESSION}" LeftMotor="{value}"/>')) for value in ("NaN", "INF")
           ],
           [f"Actions.LeftMotor: expected a number in [-1, 1], got '{value}'" for value in ("NaN", "INF")]),
    Report("a field that occurs twice counted once, and nobody knew which",
           lambda: refused(actions_of('{"Tick": 1, "Tick": 2}')), "Actions: expected each name once, got 'Tick' twice"),
    Report("a whole number above 2**53 changed on its way through a reader of doubles",
           lambda: refused(actions_of(f'{{"Session": "{SESSION}", "Tick": 9007199254740993}}')).partition(" in [")[0],
           "Actions.Tick: expected a whole number"),
    Report("an XML entity made gigabytes of a few lines",
           lambda: refused(document_of('<!DOCTYPE a [<!ENTITY x "xx">]><Actions><Say>&x;</Say></Actions>')),
           "Actions: expected XML without a document type, got one"),
    Report("an XML document read a file of the machine",
           lambda: refused(document_of(
               '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/hostname">]><Actions><Say>&x;</Say></Actions>')),
           "Actions: expected XML without a document type, got one"),
    Report("a reader failed on a field that a newer writer had added",
           lambda: decode(
               Actions, f'{{"Session": "{SESSION}", "LeftMotor": 0.5, "Mood": 1}}'.encode(), Encoding.JSON, strict=False
           ).left_motor, 0.5),
    # ---------------------------------------------------------------- maps and command lines, elsewhere
    Report("a wall without length was accepted and broke the contact",
           lambda: faults_of_wall((1.0, 2.0), (1.0, 2.0)), ["wall has the same corner twice in a row, X 1.0 Y 2.0"]),
    Report("an outline that crosses itself was inside out",
           lambda: faults_of_wall((0, 0), (1, 1), (1, 0), (0, 1), thickness=None),
           ["wall crosses itself: edges 0 and 2, counted from 0"]),
    Report("a web address was taken for an endpoint and waited for without end",
           lambda: refused(lambda: check_endpoint("http://10.0.0.5:7447", "--connect")).rpartition("; ")[2],
           "did you mean tcp/10.0.0.5:7447?"),
]  # fmt: skip
