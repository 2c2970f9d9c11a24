from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_viewer.drawings import solids
from intellwheels_viewer.drawings.solids import Solid


def volume(shape: Solid) -> float:
    a, b, c = (shape.vertices[shape.faces[:, k]].astype(float) for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def size(shape: Solid) -> list[float]:
    return [round(float(each), 4) for each in np.ptp(shape.vertices, axis=0)]


def test_a_box_is_as_large_as_it_says_and_its_faces_look_out() -> None:
    box = solids.box(0.0, 2.0, -1.0, 1.0, 0.0, 0.5)
    assert size(box) == [2.0, 2.0, 0.5]
    assert volume(box) == pytest.approx(2.0)
    assert len(box.faces) == 12


def test_a_raised_prism_of_a_hollow_corner_is_closed() -> None:
    corner = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    assert volume(solids.prism(corner, 1.0, 3.0)) == pytest.approx(6.0)
    assert volume(solids.prism(corner[::-1], 1.0, 3.0)) == pytest.approx(6.0)


def test_upholstery_fills_its_box_but_for_its_edges() -> None:
    slab = solids.slab(1.0, 0.0, 0.5, 0.4, 0.2, 0.3, radius=0.05, bevel=0.01)
    assert size(slab) == [0.5, 0.4, 0.1]
    assert 0.9 * 0.02 < volume(slab) < 0.02


def test_a_rod_is_as_long_and_as_thick_as_it_says() -> None:
    rod = solids.rod((0.0, 0.0, 0.0), (0.0, 0.0, 2.0), 0.1, 32)
    assert size(rod)[2] == 2.0
    assert volume(rod) == pytest.approx(math.pi * 0.01 * 2.0, rel=0.02)


def test_a_bent_tube_is_as_wide_and_as_high_as_it_says_and_looks_out() -> None:
    tube = solids.tube([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)], [(0.2, 0.1)] * 3, 32)
    assert size(tube) == [2.0, 0.4, 0.2]
    assert volume(tube) == pytest.approx(math.pi * 0.02 * 2.0, rel=0.02)
    bent = solids.tube([(0.0, 0.0, 1.0), (1.0, 0.5, 1.0), (1.5, 1.0, 0.2)], [(0.2, 0.2), (0.2, 0.2), (0.1, 0.1)])
    assert volume(bent) > 0.1


def test_a_tyre_touches_the_floor_and_looks_out() -> None:
    tyre = solids.hoop(0.0, 0.0, 0.3, 0.3, 0.05)
    assert float(tyre.vertices[:, 2].min()) == pytest.approx(0.0, abs=1e-6)
    assert volume(tyre) > 0.0


def test_bodies_of_ellipses_look_out() -> None:
    assert volume(solids.ball(0.0, 0.0, 1.0, 0.5, 24)) == pytest.approx(4 / 3 * math.pi * 0.125, rel=0.06)


def test_a_mirrored_solid_looks_out_too() -> None:
    rod = solids.rod((0.0, 0.2, 0.0), (0.3, 0.4, 1.0), 0.1)
    assert volume(rod.mirrored()) == pytest.approx(volume(rod))
    assert volume(solids.both(rod)) == pytest.approx(2 * volume(rod))


def test_turning_and_leaning_keep_the_size() -> None:
    box = solids.box(0.0, 2.0, 0.0, 1.0, 0.0, 1.0)
    assert size(box.turned(math.pi / 2)) == [1.0, 2.0, 1.0]
    leant = box.leaning(math.pi / 2, 0.0, 0.0)
    assert size(leant) == [1.0, 1.0, 2.0]
    assert float(leant.vertices[:, 0].max()) == pytest.approx(0.0, abs=1e-6), "it leans towards -x"


def test_rings_and_fans_look_up() -> None:
    for flat in (solids.band(0.5, 1.0, 0.1), solids.band(0.0, 1.0, 0.1, -0.3, 0.3, 4)):
        a, b, c = (flat.vertices[flat.faces[:, k]] for k in range(3))
        assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()


def test_joining_nothing_is_nothing() -> None:
    assert len(solids.join(()).faces) == 0
    assert solids.join(()).vertices.shape == (0, 3)


def test_a_pipe_has_a_rod_for_each_stretch() -> None:
    straight = solids.rod((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.1)
    bent = solids.pipe([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)], 0.1)
    assert len(bent.faces) == 2 * len(straight.faces)
