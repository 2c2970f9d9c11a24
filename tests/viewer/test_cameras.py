"""Where cameras stand: proven by projecting what they must show, and by a page that says things late, or nonsense."""

from __future__ import annotations

import itertools
import math
import threading
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from intellwheels_maps import library
from intellwheels_schemas.messages import Map
from intellwheels_viewer import cameras
from intellwheels_viewer.cameras import (
    FOV,
    MARGIN,
    PLAN_FOV,
    SEATED,
    SMALLEST,
    STEEP,
    TALLEST,
    Camera,
    Vector,
    View,
    behind,
    corners_of,
    first_person,
    fit,
    on_floor,
    plan_of,
    ray,
    shown_floor,
)
from intellwheels_viewer.head_turn import DOWN, REACH, Eye
from tests.every_case import every_case
from tests.viewer.fake_camera import FakeCamera
from tests.viewer.wire import entity

EMPTY = Map(format="iw.v1", name="empty")


def projected(points: Vector, view: View, aspect: float) -> Vector:
    """Return where points are in the picture: right and up, each in [-1, 1] when they are in it; shape (n, 2)."""
    ahead = (view.look_at - view.position) / np.linalg.norm(view.look_at - view.position)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    above = np.cross(right, ahead)
    away = points - view.position
    depth = away @ ahead
    assert (depth > 0).all()
    tall = math.tan(view.fov / 2)
    return np.column_stack([away @ right / depth / tall / aspect, away @ above / depth / tall])


def box(x: float, y: float, length: float, width: float) -> Vector:
    return np.array([(x + i * length, y + j * width, k * TALLEST) for i in (0, 1) for j in (0, 1) for k in (0, 1)])


BOXES = st.builds(box, st.floats(-200, 200), st.floats(-200, 200), st.floats(SMALLEST, 300), st.floats(SMALLEST, 300))


@settings(max_examples=200, deadline=None)
@given(BOXES, st.floats(0.3, 1.5), st.floats(0.1, 1.3), st.floats(0.3, 3.0))
def test_all_that_must_be_shown_is_in_the_picture_and_no_nearer_view_shows_it(
    points: Vector, steep: float, fov: float, aspect: float
) -> None:
    view = fit(points, steep, fov, aspect)
    spots = projected(points, view, aspect)
    assert np.abs(spots).max() <= 1.0 - 2.0 * MARGIN + 1e-6
    # Both sides of one axis touch the margin: nearer, one of them would be cut.
    low, high = spots.min(axis=0), spots.max(axis=0)
    assert np.minimum(-low, high).max() == pytest.approx(1.0 - 2.0 * MARGIN, abs=1e-6)
    assert view.look_at[2] == pytest.approx(0.0, abs=1e-6)
    assert view.fov == fov


@every_case("name", ["room", "ward"])
@every_case("aspect", [0.5, 0.9, 1.6, 2.4])
def test_the_first_view_shows_a_floor_whole_whatever_the_panels_leave(name: str, aspect: float) -> None:
    corners = corners_of(library.floor(name))
    for view in (fit(corners, STEEP, FOV, aspect), plan_of(corners, aspect)):
        assert np.abs(projected(corners * (1, 1, view.fov != PLAN_FOV), view, aspect)).max() < 1.0


@pytest.mark.parametrize("name", ["room", "ward", "crossing", "corridor15m", "lounge", "square", "corner", "door"])
@pytest.mark.parametrize(
    ("width", "height", "covered"),
    [(1024, 900, 0.0), (704, 800, 0.0), (820, 1180, 0.43), (390, 844, 0.07), (390, 844, 0.63)],
)
def test_the_floor_fills_what_panels_leave(name: str, width: int, height: int, covered: float) -> None:
    corners = corners_of(library.floor(name))
    ground = corners[corners[:, 2] == 0.0]
    for view in (
        fit(corners, STEEP, FOV, width / height, covered),
        plan_of(corners, width / height, covered),
    ):
        spots = projected(corners * (1, 1, view.fov != PLAN_FOV), view, width / height)
        # Nothing is behind a panel, and the floor is large.
        assert spots[:, 1].min() >= -1.0 + 2.0 * covered
        assert np.abs(spots).max() < 1.0
        across, up = np.ptp(projected(ground, view, width / height), axis=0)
        assert max(across / 2.0, up / 2.0 / (1.0 - covered)) >= 0.7


def test_a_long_map_is_upright_in_an_upright_picture_and_north_is_in_the_upper_half_of_all_others() -> None:
    corners = corners_of(library.floor("ward"))
    for aspect, least, most in ((0.46, 90.0, 90.0), (0.88, 15.0, 60.0), (1.6, 0.0, 0.0)):
        view = fit(corners, STEEP, FOV, aspect)
        assert least <= side_of(view) <= most + 1e-6


def side_of(view: View) -> float:
    """Return from which side a view is, in degrees from the south towards the west."""
    return math.degrees(math.atan2(*(view.look_at - view.position)[:2]))


def test_a_wide_floor_is_seen_from_where_it_is_much_larger_and_others_from_the_south() -> None:
    # What two panels leave in a window of 1440 x 900.
    aspect = 864 / 900
    for name, least in (("ward", 1.4), ("crossing", 1.5), ("corridor15m", 1.5)):
        corners = corners_of(library.floor(name))
        view, south = fit(corners, STEEP, FOV, aspect), cameras._fitted(corners, STEEP, FOV, aspect, 0.0, 0.0)
        assert shown_floor(corners, view, aspect) > least * shown_floor(corners, south, aspect)
        assert 15.0 <= side_of(view) <= 60.0
        across, up = np.ptp(projected(corners * (1, 1, 0), view, aspect), axis=0) / 2.0
        assert max(across, up) >= 0.85
        assert min(across, up) >= 0.7
    assert side_of(fit(corners_of(library.floor("room")), STEEP, FOV, aspect)) == pytest.approx(0.0)


def test_the_share_that_a_floor_fills_is_that_of_its_picture() -> None:
    # From straight above: a square of 2 m from 10 m, in a picture of 2 x 10 m times the tangent of half the lens.
    view = View(np.array([0.0, -1e-6, 10.0]), np.zeros(3), 2.0 * math.atan(0.5))
    corners = np.array([(x, y, 0.0) for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    assert shown_floor(corners, view, 1.0) == pytest.approx(0.04, rel=1e-3)
    assert shown_floor(corners, view, 2.0) == pytest.approx(0.02, rel=1e-3)


def test_the_corners_are_those_of_walls_and_all_else_from_the_floor_to_the_tallest_name() -> None:
    floor = library.floor("room")
    corners = corners_of(floor)
    xs = [corner.x for wall in floor.wall for corner in wall.corner]
    assert corners.shape == (8, 3)
    assert corners[:, 0].min() <= min(xs)
    assert corners[:, 0].max() >= max(xs)
    assert set(corners[:, 2]) == {0.0, TALLEST}


@pytest.mark.parametrize("aspect", [0.5, 1.6])
def test_a_floor_with_nothing_on_it_has_a_view(aspect: float) -> None:
    from intellwheels_schemas.messages import Corner, Wall

    dot = Map(format="iw.v1", name="dot", wall=(Wall(thickness=0.1, corner=(Corner(x=3.0, y=4.0),) * 2),))
    for floor in (EMPTY, dot):
        corners = corners_of(floor)
        assert np.ptp(corners[:, 0]) >= SMALLEST
        for view in (fit(corners, STEEP, FOV, aspect), plan_of(corners, aspect)):
            assert np.isfinite(np.concatenate([view.position, view.look_at])).all()
            assert np.linalg.norm(view.position - view.look_at) > 1.0


def test_the_plan_is_from_above_and_north_is_up() -> None:
    view = plan_of(corners_of(library.floor("room")), 1.6)
    down = (view.look_at - view.position) / np.linalg.norm(view.look_at - view.position)
    assert down[2] < -0.999
    spots = projected(np.array([(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]), view, 1.6)
    assert spots[1][1] > spots[0][1]
    assert spots[2][0] > spots[0][0]


def test_who_sits_looks_ahead_from_the_height_of_the_head() -> None:
    view = first_person(entity("a", 2.0, 3.0, heading=math.pi / 2))
    assert view.position == pytest.approx((2.0, 3.05, 1.2))
    assert view.look_at[1] > view.position[1]
    assert view.fov == SEATED.fov


@pytest.mark.parametrize("turned", [0.0, 0.6])
def test_the_view_from_the_chair_is_the_place_that_the_plan_shows(turned: float) -> None:
    # The corners of the room and the jambs of its door, at the floor and at the top.
    plan_points = np.array([(0.0, 0.0), (8.95, 0.0), (8.95, 8.0), (9.0, 3.45), (9.0, 4.55), (13.0, 5.0)])
    chair = entity("a", 1.2, 3.0, heading=0.1)
    eye = Eye(0.12, 1.2, math.radians(88.0))
    first = first_person(chair, eye, yaw=turned)
    plan = plan_of(corners_of(library.floor("room")), 1.6)
    on_plan = projected(np.column_stack([plan_points, np.zeros(6)]), plan, 1.6)
    (here,) = projected(np.array([(*first.position[:2], 0.0)]), plan, 1.6)
    (ahead,) = projected(np.array([(first.position[0] + 1.0, first.position[1], 0.0)]), plan, 1.6)
    metre = (ahead[0] - here[0]) * 1.6  # in half heights of the picture
    seen = 0
    for height, (point, there) in itertools.product((0.0, 2.5), zip(plan_points, on_plan, strict=True)):
        east, north = (there[0] - here[0]) * 1.6 / metre, (there[1] - here[1]) / metre
        bearing, far = math.atan2(north, east) - chair.heading - turned, math.hypot(north, east)
        if abs(bearing) < 0.9:  # before the eye
            seen += 1
            (spot,) = projected(np.array([(*point, height)]), first, 1.6)
            # What a lens that looks down by DOWN makes of a point at this bearing, distance and height.
            ahead_of, aside, above = far * math.cos(bearing), -far * math.sin(bearing), height - eye.height
            depth = ahead_of * math.cos(DOWN) - above * math.sin(DOWN)
            up = ahead_of * math.sin(DOWN) + above * math.cos(DOWN)
            tall = math.tan(eye.fov / 2)
            assert spot[0] == pytest.approx(aside / depth / tall / 1.6, abs=0.01)
            assert spot[1] == pytest.approx(up / depth / tall, abs=0.01)
    assert seen >= 6


def test_following_begins_behind_and_above() -> None:
    view = behind(entity("a", 2.0, 3.0, heading=0.0))
    assert view.position[0] < 2.0
    assert view.position[2] > view.look_at[2]


# ---------------------------------------------------------------- rays


def test_a_ray_meets_the_floor_where_it_points() -> None:
    assert on_floor((1.0, 2.0, 4.0), (1.0, 0.0, -2.0)) == pytest.approx((3.0, 2.0))


@every_case(
    ("origin", "direction"),
    [
        ((0, 0, 1), (1, 0, 0)), ((0, 0, 1), (0, 0, 1)), ((0, 0, -1), (0, 0, -1)), ((0, 0, 1), (1, 0, -1e-7)),
        ((0, 0, 1), (math.nan, 0, -1)), ((0, 0, 1), (0, math.nan, -1)), ((0, 0, 1), (0, 0, math.nan)),
        ((math.inf, 0, 1), (0, 0, -1)), ((0, 0, math.nan), (0, 0, -1)), ((0, 0, math.inf), (0, 0, -1)),
        ((5, 0, 1), (0, math.inf, -1)),
    ],
)  # fmt: skip
def test_a_ray_that_meets_no_floor_meets_nothing(origin: tuple[float, ...], direction: tuple[float, ...]) -> None:
    assert on_floor(origin, direction) is None


def test_the_line_of_sight_through_a_projected_point_meets_it() -> None:
    camera = FakeCamera().camera
    points = np.array([(2.0, 1.0, 0.0), (-1.0, 0.5, 0.0)])
    view = View(np.array(camera.position), np.array(camera.look_at), camera.fov)
    for point, (right, up) in zip(points, projected(points, view, camera.aspect), strict=True):
        assert on_floor(*ray(cast(Any, camera), right, up)) == pytest.approx(tuple(point[:2]), abs=1e-9)


# ---------------------------------------------------------------- a browser's camera


@pytest.fixture
def client() -> FakeCamera:
    return FakeCamera()


@pytest.fixture
def camera(client: FakeCamera) -> Camera:
    made = Camera(cast(Any, client))
    client.report()  # the page's first word: its window
    return made


ROOM = library.floor("room")


def shows(client: FakeCamera, floor: Map = ROOM) -> bool:
    view = View(np.array(client.camera.position), np.array(client.camera.look_at), client.camera.fov)
    return bool(np.abs(projected(corners_of(floor), view, client.camera.aspect)).max() < 1.0)


def test_another_floor_is_shown_whole(client: FakeCamera, camera: Camera) -> None:
    camera.frame(ROOM)
    assert shows(client)
    camera.frame(library.floor("ward"))
    assert shows(client, library.floor("ward"))


def test_the_view_is_fitted_again_when_panels_dock_and_nobody_moved_it(client: FakeCamera, camera: Camera) -> None:
    camera.frame(ROOM)
    client.resize(500, 900)
    assert shows(client)


def test_who_has_moved_the_view_keeps_it(client: FakeCamera, camera: Camera) -> None:
    camera.frame(ROOM)
    client.report()  # the echo of ours
    client.report(position=(1.0, 1.0, 1.0))
    client.resize(500, 900)
    assert tuple(client.camera.position) == (1.0, 1.0, 1.0)


def test_late_echoes_are_no_moves_of_the_user(client: FakeCamera, camera: Camera) -> None:
    camera.frame(ROOM)
    first = client.camera.position
    client.report()
    camera.frame(library.floor("ward"))
    client.report(position=np.asarray(first, np.float32))
    client.resize(500, 900)
    client.report(look_at=client.camera.look_at)
    assert shows(client, library.floor("ward"))


def test_the_page_says_how_wide_the_scene_is_if_the_report_of_its_camera_does_not(
    client: FakeCamera, camera: Camera
) -> None:
    camera.frame(library.floor("ward"))
    client.report()
    before = np.array(client.camera.position)
    camera.leave_free(0.0, 0.5)
    narrow = fit(corners_of(library.floor("ward")), STEEP, FOV, 0.5)
    assert np.array(client.camera.position) == pytest.approx(narrow.position)
    assert not np.allclose(narrow.position, before)
    camera.leave_free(0.0, 0.5004)  # rounding
    assert np.array(client.camera.position) == pytest.approx(narrow.position)
    # A report that was on its way says what was before.
    client.report(aspect=1.28, image_width=1280, image_height=1000)
    assert np.array(client.camera.position) == pytest.approx(narrow.position)
    assert camera.picture is not None
    assert camera.picture.width == pytest.approx(500.0)
    # A user who has moved the view keeps it.
    client.report()
    client.report(position=tuple(narrow.position + 1.0))
    camera.leave_free(0.0, 1.5)
    assert np.array(client.camera.position) == pytest.approx(narrow.position + 1.0)


def test_following_goes_along_and_keeps_the_users_orbit(client: FakeCamera, camera: Camera) -> None:
    camera.choose("follow", entity("a"))
    client.report()
    around = np.array(client.camera.look_at) + np.array([0.0, 5.0, 5.0])
    client.report(position=tuple(around))
    camera.follow(entity("a", 3.0))
    assert np.array(client.camera.position) - np.array(client.camera.look_at) == pytest.approx((0.0, 5.0, 5.0))
    assert client.camera.look_at[0] == pytest.approx(3.0)


def test_following_what_stands_writes_nothing(client: FakeCamera, camera: Camera) -> None:
    camera.choose("follow", entity("a"))
    client.camera.position = "untouched"
    camera.follow(entity("a"))
    assert client.camera.position == "untouched"


def test_first_person_sits_in_the_chair(client: FakeCamera, camera: Camera) -> None:
    camera.choose("first", entity("a", 2.0, heading=0.0))
    camera.follow(entity("a", 4.0, heading=0.0))
    assert client.camera.position[0] == pytest.approx(4.05)
    assert client.camera.fov == SEATED.fov


def test_the_mouse_turns_the_head_and_the_chair_goes_on(client: FakeCamera, camera: Camera) -> None:
    camera.choose("first", entity("a", 2.0))
    client.report()
    assert camera.turning == 0.0
    eye, look = np.array(client.camera.position), np.array(client.camera.look_at)
    # The page turns the view about a point just ahead: half a turn to the left.
    client.report(position=tuple(look + np.array([0.0, -REACH, 0.0])), look_at=tuple(look))
    assert camera.turning > 0.0
    camera.follow(entity("a", 3.0))
    moved, ahead = np.array(client.camera.position), np.array(client.camera.look_at)
    assert moved == pytest.approx(eye + np.array([1.0, 0.0, 0.0]))
    assert (ahead - moved)[1] == pytest.approx(REACH, abs=1e-3)
    camera.choose("first", entity("a", 3.0))
    assert camera.turning == 0.0


def test_nobody_can_be_followed_but_somebody(camera: Camera) -> None:
    camera.choose("follow", None)
    assert camera.mode == "free"
    camera.choose("first", None)
    assert camera.mode == "free"
    camera.choose("plan", None)
    assert str(camera.mode) == "plan"


def test_an_orbit_of_the_plan_is_no_plan_any_more(client: FakeCamera, camera: Camera) -> None:
    camera.frame(ROOM)
    camera.choose("plan", None)
    assert client.camera.fov == PLAN_FOV
    client.report()
    client.report(position=tuple(np.array(client.camera.position) + np.array([100.0, 0.0, 0.0])))
    assert camera.mode == "free"
    assert client.camera.fov == FOV


def test_the_far_plane_is_behind_the_floor_however_large_it_is(client: FakeCamera, camera: Camera) -> None:
    from intellwheels_schemas.messages import Corner, Wall

    line = (Corner(x=-900.0, y=0.0), Corner(x=900.0, y=0.0))
    camera.frame(Map(format="iw.v1", name="long", wall=(Wall(thickness=0.1, corner=line),)))
    camera.choose("plan", None)
    away = np.linalg.norm(np.array(client.camera.position) - np.array(client.camera.look_at))
    assert client.camera.far > away


@pytest.mark.parametrize(
    "nonsense",
    [
        {"position": (math.nan, 0.0, 0.0)}, {"look_at": (math.inf, 0.0, 0.0)},
        {"image_height": 0, "aspect": math.inf}, {"position": (0.0, 0.0, 0.0), "look_at": (0.0, 0.0, 0.0)},
    ],
)  # fmt: skip
def test_what_is_no_camera_is_not_believed(client: FakeCamera, camera: Camera, nonsense: dict[str, Any]) -> None:
    camera.frame(ROOM)
    client.report()
    before = dict(vars(client.camera))
    client.report(**nonsense)
    vars(client.camera).update(before)
    client.report()
    camera.frame(ROOM)
    assert shows(client)


def test_a_camera_that_cannot_be_set_is_left(client: FakeCamera) -> None:
    class Stubborn:
        on_update = staticmethod(lambda call: call)

        def __setattr__(self, name: str, value: object) -> None:
            raise ValueError("Camera look_at must be finite")

    client.camera = Stubborn()
    camera = Camera(cast(Any, client))
    camera.frame(ROOM)
    camera.choose("first", entity("a"))
    camera.follow(entity("a", 1.0))


def test_a_mode_that_changes_while_it_is_drawn_stops_nothing(camera: Camera) -> None:
    faults: list[Exception] = []
    done = threading.Event()

    def draw() -> None:
        x = 0.0
        while not done.is_set():
            x += 0.1
            try:
                camera.follow(entity("a", x))
            except Exception as fault:
                faults.append(fault)

    drawing = threading.Thread(target=draw)
    drawing.start()
    for _ in range(400):
        for mode in ("follow", "first", "free", "plan"):
            camera.choose(cast(Any, mode), entity("a"))
    done.set()
    drawing.join(10.0)
    assert faults == []
