"""Noise is a function of seed, agent, stream, tick and draw, the same on every machine."""

from __future__ import annotations

import hashlib
import statistics

import numpy as np
import pytest

from intellwheels_server.world.kernels.noise import noise_key, normal, normal_quantile, threefry, uniform

_ONES = 0xFFFFFFFFFFFFFFFF


@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ((0, 0), (0, 0), (0xC2B6E3A8C2C69865, 0x6F81ED42F350084D)),
        ((_ONES, _ONES), (_ONES, _ONES), (0xE02CB7C4D95D277A, 0xD06633D0893B8B68)),
        (
            (0x243F6A8885A308D3, 0x13198A2E03707344),
            (0xA4093822299F31D0, 0x082EFA98EC4E6C89),
            (0x263C7D30BB0F0AF1, 0x56BE8361D3311526),
        ),
    ],
)
def test_threefry_gives_the_published_answers(
    counter: tuple[int, int], key: tuple[int, int], expected: tuple[int, int]
) -> None:
    # Source: Random123, tests/kat_vectors, lines "threefry2x64 20".
    words = threefry(np.uint64(key[0]), np.uint64(key[1]), np.uint64(counter[0]), np.uint64(counter[1]))
    assert (int(words[0]), int(words[1])) == expected


def test_quantile_is_as241() -> None:
    # Python's statistics module computes AS 241 with the C library's logarithm.
    reference = statistics.NormalDist()
    for p in [2.0**-53, 1e-15, 1e-9, 0.001, 0.0749, 0.075, 0.3, 0.5, 0.9, 0.925, 0.9251, 0.99999, 1.0 - 2.0**-53]:
        assert normal_quantile(p) == pytest.approx(reference.inv_cdf(p), rel=1e-15, abs=1e-300)


def test_uniform_never_gives_zero_or_one_and_normal_is_finite() -> None:
    words = np.array([0, _ONES], dtype=np.uint64) >> np.uint64(12)
    low, high = (words.astype(np.float64) + 0.5) * 2.0**-52
    assert 0.0 < low < high < 1.0
    assert -8.3 < normal_quantile(low) < 0.0 < normal_quantile(high) < 8.3


def test_uniform_and_normal_have_the_moments_of_their_distributions() -> None:
    key0, key1 = noise_key("1", "chair1", "front")
    flat = np.array([uniform(key0, key1, tick, 0) for tick in range(20_000)])
    bell = np.array([normal(key0, key1, tick, 1) for tick in range(20_000)])
    # Five standard errors of 20,000 draws.
    assert abs(flat.mean() - 0.5) < 5 * (1 / 12 / 20_000) ** 0.5
    assert abs(bell.mean()) < 5 * (1 / 20_000) ** 0.5
    assert abs(bell.var() - 1.0) < 5 * (2 / 20_000) ** 0.5
    assert abs(np.corrcoef(bell[1:], bell[:-1])[0, 1]) < 5 / 20_000**0.5


def test_key_is_blake2b_of_the_three_texts_with_their_lengths() -> None:
    encoded = b"".join(len(text).to_bytes(8, "little") + text for text in (b"s", b"chair1", "µ".encode()))
    digest = hashlib.blake2b(encoded, digest_size=16).digest()
    expected = int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:], "little")
    key0, key1 = noise_key("s", "chair1", "µ")
    assert (int(key0), int(key1)) == expected


def test_no_two_ways_of_cutting_the_same_letters_share_a_key() -> None:
    keys = {noise_key(*cut) for cut in [("a", "bc", "d"), ("ab", "c", "d"), ("a", "b", "cd"), ("", "abc", "d")]}
    assert len(keys) == 4


def test_every_tick_and_every_draw_has_its_own_number() -> None:
    key0, key1 = noise_key("1", "chair1", "front")
    draws = {uniform(key0, key1, tick, draw) for tick in range(50) for draw in range(4)}
    assert len(draws) == 200
