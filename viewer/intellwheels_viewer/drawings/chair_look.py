"""A wheelchair of the declared size: base and seat from its parts, drive wheels from its track and wheel diameter.

Nothing is outside the box around the parts, and the headrest and the footrests reach its top and its front: space that
looks free in the picture is free in the simulation. The painted surfaces are visible from above too.
"""

from __future__ import annotations

import math

from intellwheels_schemas.messages import Robot
from intellwheels_viewer.drawings import real_badge
from intellwheels_viewer.drawings.body_look import BodyLook
from intellwheels_viewer.drawings.chair_frame import Frame, arm_ends, arm_height, frame_of, stick
from intellwheels_viewer.drawings.furniture import Painted, merged
from intellwheels_viewer.drawings.occupant import occupant
from intellwheels_viewer.drawings.solids import Point, Solid, ball, both, box, hoop, join, loft, pipe, rod, slab
from intellwheels_viewer.drivers import reality_of

_LEAN = math.radians(9.0)


def chair(robot: Robot, *, crowd: bool = False, occupied: bool = False) -> BodyLook:
    """Return the look of a wheelchair; in a crowd it has at most 600 triangles.

    Args:
        robot: The document. A real chair, or a stand-in for one, has a white band and plates that say so.
        crowd: Whether it is one of many.
        occupied: Whether somebody sits in it.
    """
    frame = frame_of(robot)
    shirt, person = occupant(frame, crowd=crowd) if occupied else (Solid(), {})
    word = real_badge.WORDS[reality_of(robot)]
    more = merged(person, _finish(frame, word) if word else {})
    stripe = (frame.rear + 0.42 * (frame.front - frame.rear), frame.seat + 0.012, 0.6 * frame.wide)
    if crowd:
        return BodyLook(_plain_paint(frame) + shirt, _plain_dark(frame), more=more, stripe=stripe)
    paint = join([_fairing(frame), _tray(frame), _shell(frame), _headrest(frame), _skirts(frame), shirt])
    dark = join([_base(frame), _cushions(frame), _tyres(frame), _castors(frame), _arms(frame), _plates(frame)])
    light = join([_spokes(frame), _forks(frame), _hangers(frame), _posts(frame)])
    return BodyLook(paint, dark, light, more=more, stripe=stripe)


def _finish(frame: Frame, word: str) -> Painted:
    """Return what only a real chair has: a white band around its back and its side boards, and its plates."""
    x = frame.rear + 0.065 + math.tan(_LEAN) * (frame.back - frame.seat)
    flat = real_badge.upright(x - 0.034, (frame.seat + frame.back) / 2, 0.8 * min(frame.wide, 0.46), word)
    plates = {rgb: each.leaning(_LEAN, x, frame.seat) for rgb, each in flat.items()}
    band = _upright(frame, frame.wide - 0.06, frame.back - 0.10, frame.back - 0.04, 0.075, 0.065)
    start, end = arm_ends(frame)
    y, z = frame.wide / 2 - 0.02, frame.seat - 0.005
    side = both(box(start + 0.03, end - 0.04, y, y + 0.004, z, z + 0.035))
    return merged(plates, {real_badge.LETTERS: band + side}, real_badge.on_floor(frame.hull, word))


# ---------------------------------------------------------------- seat


def _tray(frame: Frame) -> Solid:
    """Return the painted rim around the cushion."""
    length, width = frame.front - frame.rear - 0.06, frame.wide - 0.06
    x = (frame.rear + frame.front) / 2 + 0.03
    return slab(x, 0.0, length, width, frame.seat - 0.10, frame.seat - 0.025, radius=0.07, bevel=0.015)


def _cushions(frame: Frame) -> Solid:
    """Return the upholstery of seat, back and headrest."""
    length, width = frame.front - frame.rear, frame.wide
    x = (frame.rear + frame.front) / 2
    seat = slab(x + 0.045, 0.0, length - 0.17, width - 0.15, frame.seat - 0.06, frame.seat, radius=0.06, bevel=0.02)
    back = _upright(frame, width - 0.16, frame.seat, frame.back - 0.035, 0.06, 0.115)
    head = _level(frame, 0.07, 0.20, frame.hull.top - 0.15, frame.hull.top - 0.035, 0.135)
    return join([seat, back, head])


def _shell(frame: Frame) -> Solid:
    return _upright(frame, frame.wide - 0.08, frame.seat - 0.10, frame.back, 0.06, 0.065)


def _upright(frame: Frame, width: float, z0: float, z1: float, thick: float, ahead: float) -> Solid:
    """Return a padded board across, `ahead` of the seat's rear at the seat's height, leaning back."""
    x = frame.rear + ahead + math.tan(_LEAN) * (frame.back - frame.seat)
    flat = slab(0.0, 0.0, z1 - z0, width, -thick / 2, thick / 2, radius=0.07, bevel=0.02)
    # Turn it upright: the old x axis points up, the old z axis forward.
    stood = Solid(flat.vertices[:, [2, 1, 0]] * (1, 1, 1), flat.faces[:, ::-1].copy())
    return stood.moved(x, 0.0, (z0 + z1) / 2).leaning(_LEAN, x, frame.seat)


def _level(frame: Frame, thick: float, width: float, z0: float, z1: float, ahead: float) -> Solid:
    return slab(frame.rear + ahead, 0.0, thick, width, z0, z1, radius=0.03, bevel=0.015)


def _headrest(frame: Frame) -> Solid:
    return _level(frame, 0.09, 0.28, frame.hull.top - 0.19, frame.hull.top, 0.075)


def _arms(frame: Frame) -> Solid:
    """Return the armrests' pads and the joystick on the right one."""
    y, z = frame.wide / 2 - 0.035, arm_height(frame)
    start, end = arm_ends(frame)
    pads = both(slab((start + end) / 2, y, end - start, 0.07, z - 0.035, z, radius=0.03, bevel=0.012))
    x, aside = stick(frame)
    joystick = [
        slab(x, aside, 0.11, 0.075, z - 0.01, z + 0.035, radius=0.02, bevel=0.01),
        rod((x, aside, z + 0.03), (x, aside, z + 0.10), 0.009),
        ball(x, aside, z + 0.11, 0.023, 8),
    ]
    return join([pads, *joystick])


def _skirts(frame: Frame) -> Solid:
    """Return the painted boards between seat and armrests, which keep clothes away from the wheels."""
    start, end = arm_ends(frame)
    y, top = frame.wide / 2, arm_height(frame) - 0.075
    bottom = frame.seat - 0.09
    side = [(start + 0.02, bottom), (end - 0.03, bottom), (end - 0.09, top), (start + 0.02, top)]
    rings: list[list[Point]] = [[(x, y - depth, z) for x, z in side] for depth in (0.045, 0.020)]
    return both(loft(rings))


def _posts(frame: Frame) -> Solid:
    """Return the metal that holds armrests, headrest and push handles."""
    y, z = frame.wide / 2 - 0.035, arm_height(frame) - 0.03
    start, end = arm_ends(frame)
    posts = [both(rod((x, y, frame.seat - 0.08), (x, y, z), 0.012)) for x in (start + 0.06, end - 0.06)]
    head = frame.rear + 0.075
    stem = rod((head, 0.0, frame.back - 0.12), (head, 0.0, frame.hull.top - 0.1), 0.014)
    lease = frame.back - 0.06
    handle = pipe(
        [(frame.rear + 0.07, 0.2, lease - 0.05), (frame.rear + 0.05, 0.2, lease), (frame.rear, 0.2, lease)], 0.015
    )
    return join([*posts, stem, both(handle)])


# ---------------------------------------------------------------- wheels and base


def _fairing(frame: Frame) -> Solid:
    """Return the painted cover of batteries and motors between the wheels."""
    start, end = _base_ends(frame)
    width = 2 * (frame.side - frame.tyre / 2) - 0.05
    top = max(frame.seat - 0.13, 0.22)
    return slab((start + end) / 2, 0.0, end - start, width, 0.17, top, radius=0.08, bevel=0.04)


def _base(frame: Frame) -> Solid:
    start, end = _base_ends(frame)
    width = 2 * (frame.side - frame.tyre / 2) - 0.09
    return slab((start + end) / 2, 0.0, end - start - 0.04, width, 0.07, 0.19, radius=0.06, bevel=0.02)


def _base_ends(frame: Frame) -> tuple[float, float]:
    return max(frame.hull.rear + 0.10, frame.rear), min(frame.hull.front - 0.24, frame.front - 0.02)


def _tyres(frame: Frame) -> Solid:
    return both(hoop(0.0, frame.side, frame.wheel, frame.wheel, frame.tyre, 24, 6))


def _spokes(frame: Frame) -> Solid:
    """Return the rims, hubs and spokes, and the hand rims a finger's width outside the tyres."""
    r, y, t = frame.wheel, frame.side, frame.tyre
    rim = hoop(0.0, y, r, r - 0.75 * t, 0.016, 20, 4)
    hub = rod((0.0, y - 0.02, r), (0.0, y + t / 2, r), 0.2 * r, 10)
    turns = [2 * math.pi * index / 8 for index in range(8)]
    reach = r - 0.8 * t
    ends: list[Point] = [(reach * math.cos(t_), y, r + reach * math.sin(t_)) for t_ in turns]
    spokes = [rod((0.0, y + 0.4 * t, r), end, 0.006, 3) for end in ends]
    outside = min(y + t / 2 + 0.014, frame.hull.left - 0.008)
    hand = hoop(0.0, outside, r, r - 0.35 * t, 0.014, 20, 4)
    return both(join([rim, hub, *spokes, hand]))


def _castor_places(frame: Frame) -> list[tuple[float, float, float]]:
    """Return x, y and radius of the castors on the left: at each end that is far enough from the drive wheels."""
    radius = 0.085
    y = frame.hull.width / 2 - 0.10
    places = []
    if frame.hull.front > frame.wheel + 0.2:
        places.append((frame.hull.front - 0.27, y, radius))
    if -frame.hull.rear > frame.wheel + 0.2:
        places.append((frame.hull.rear + radius + 0.005, y, radius))
    return places


def _castors(frame: Frame) -> Solid:
    return join(both(hoop(x, y, r, r, 0.045, 12, 4)) for x, y, r in _castor_places(frame))


def _forks(frame: Frame) -> Solid:
    """Return the forks of the castors, their pins and the arms that hold them."""
    start, end = _base_ends(frame)
    solids = []
    for x, y, r in _castor_places(frame):
        hold = min(max(x, start), end)
        solids += [
            rod((x, y - 0.03, r), (x, y + 0.03, r), 0.02),
            rod((x, y + 0.028, r), (x, y + 0.012, 2 * r + 0.03), 0.009),
            rod((x, y - 0.028, r), (x, y - 0.012, 2 * r + 0.03), 0.009),
            rod((x, y, 2 * r + 0.01), (x, y, 2 * r + 0.07), 0.018),
            pipe([(x, y, 2 * r + 0.05), (hold, y, 2 * r + 0.05), (hold, y - 0.14, 2 * r + 0.05)], 0.014),
        ]
    return both(join(solids))


def _hangers(frame: Frame) -> Solid:
    """Return the tubes from the seat down to the footrests."""
    front, knee = frame.hull.front, frame.front - 0.06
    foot = front - 0.10
    return both(
        pipe([(knee, 0.17, frame.seat - 0.10), (knee + 0.08, 0.17, frame.seat - 0.11), (foot, 0.15, 0.13)], 0.016)
    )


def _plates(frame: Frame) -> Solid:
    """Return the footrests, which end where the body does."""
    front = frame.hull.front
    depth = min(0.20, 0.5 * frame.hull.length)
    plate = slab(front - depth / 2, 0.115, depth, 0.16, 0.10, 0.125, radius=0.03, bevel=0.005)
    heel = box(front - depth, front - depth + 0.015, 0.05, 0.18, 0.12, 0.17)
    return both(plate + heel)


# ---------------------------------------------------------------- the chair of a crowd


def _plain_paint(frame: Frame) -> Solid:
    start, end = _base_ends(frame)
    half = frame.side - frame.tyre / 2 - 0.02
    return join(
        [
            box(start, end, -half, half, 0.10, frame.seat - 0.13),
            box(
                frame.rear + 0.03,
                frame.front,
                -frame.wide / 2 + 0.03,
                frame.wide / 2 - 0.03,
                frame.seat - 0.1,
                frame.seat - 0.03,
            ),
            _level(frame, 0.08, frame.wide - 0.08, frame.seat - 0.1, frame.back, 0.05),
            box(frame.rear + 0.03, frame.rear + 0.12, -0.14, 0.14, frame.back, frame.hull.top),
        ]
    )


def _plain_dark(frame: Frame) -> Solid:
    r, t = frame.wheel, frame.tyre
    wheel = rod((0.0, frame.side - t / 2, r), (0.0, frame.side + t / 2, r), r, 14)
    small = [rod((x, y - 0.02, c), (x, y + 0.02, c), c, 8) for x, y, c in _castor_places(frame)]
    cushion = box(
        frame.rear + 0.13,
        frame.front - 0.04,
        -frame.wide / 2 + 0.08,
        frame.wide / 2 - 0.08,
        frame.seat - 0.03,
        frame.seat,
    )
    front = frame.hull.front
    plate = box(front - 0.2, front, 0.03, 0.19, 0.10, 0.125)
    arm = box(*arm_ends(frame), frame.wide / 2 - 0.07, frame.wide / 2, arm_height(frame) - 0.03, arm_height(frame))
    return join([both(join([wheel, *small, plate, arm])), cushion])
