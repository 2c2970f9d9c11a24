"""Random numbers that depend on a key and a counter only, never on earlier draws.

A draw is Threefry-2x64-20 of a key (seed, agent, stream) and a counter (tick, draw). So a new
sensor or agent does not change the noise of others, and any tick can be drawn alone.

Sources:
    Salmon, Moraes, Dror, Shaw (2011), Parallel random numbers: as easy as 1, 2, 3.
    Wichura (1988), Algorithm AS 241: the percentage points of the normal distribution,
    Applied Statistics 37(3), routine PPND16.
"""

from __future__ import annotations

import hashlib
import math
from functools import lru_cache

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.elementary import log

_PARITY = np.uint64(0x1BD11BDAA9FC1A22)
# The rotations repeat every eight rounds; the key is added after every four.
_R0, _R1, _R2, _R3 = np.uint64(16), np.uint64(42), np.uint64(12), np.uint64(31)
_R4, _R5, _R6, _R7 = np.uint64(16), np.uint64(32), np.uint64(24), np.uint64(21)
_WORD = np.uint64(64)
_TWELVE = np.uint64(12)


@lru_cache(maxsize=4096)  # every join asks for the keys of all sensors again
def noise_key(seed: str, agent: str, stream: str) -> tuple[np.uint64, np.uint64]:
    """Return the key of one stream of noise.

    Args:
        seed: The run's seed, any text.
        agent: Name of the body to which the noise belongs.
        stream: The source of the noise in the body: the id of a sensor, or a word that no id can be.

    Returns:
        The first and second half, little-endian, of 128 bits of BLAKE2b over the three
        texts in UTF-8, each preceded by its length in bytes as eight little-endian bytes.
    """
    digest = hashlib.blake2b(digest_size=16)
    for text in (seed, agent, stream):
        encoded = text.encode()
        digest.update(len(encoded).to_bytes(8, "little"))
        digest.update(encoded)
    raw = digest.digest()
    return np.uint64(int.from_bytes(raw[:8], "little")), np.uint64(int.from_bytes(raw[8:], "little"))


@njit(cache=True, error_model="numpy")
def _round(x0: np.uint64, x1: np.uint64, turn: np.uint64) -> tuple[np.uint64, np.uint64]:
    x0 = x0 + x1
    x1 = (x1 << turn) | (x1 >> (_WORD - turn))
    return x0, x1 ^ x0


@njit(cache=True, error_model="numpy")
def threefry(key0: np.uint64, key1: np.uint64, counter0: np.uint64, counter1: np.uint64) -> tuple[np.uint64, np.uint64]:
    """Return the two 64-bit words of Threefry-2x64 with 20 rounds.

    All arguments must be unsigned 64-bit: numba would convert a mixed sum to a float.
    """
    key2 = _PARITY ^ key0 ^ key1
    x0 = counter0 + key0
    x1 = counter1 + key1
    for group in range(5):
        if group % 2 == 0:
            x0, x1 = _round(x0, x1, _R0)
            x0, x1 = _round(x0, x1, _R1)
            x0, x1 = _round(x0, x1, _R2)
            x0, x1 = _round(x0, x1, _R3)
        else:
            x0, x1 = _round(x0, x1, _R4)
            x0, x1 = _round(x0, x1, _R5)
            x0, x1 = _round(x0, x1, _R6)
            x0, x1 = _round(x0, x1, _R7)
        # Key schedule: after group g the words (g+1) mod 3 and (g+2) mod 3, and g+1 on the second.
        if group % 3 == 0:
            x0 = x0 + key1
            x1 = x1 + key2
        elif group % 3 == 1:
            x0 = x0 + key2
            x1 = x1 + key0
        else:
            x0 = x0 + key0
            x1 = x1 + key1
        x1 = x1 + np.uint64(group + 1)
    return x0, x1


@njit(cache=True, error_model="numpy")
def uniform(key0: np.uint64, key1: np.uint64, tick: int, draw: int) -> float:
    """Return a uniform number in the open interval (0, 1), a multiple of 2^-53.

    Args:
        key0: First half of the stream's key.
        key1: Second half.
        tick: Tick of the run, >= 0.
        draw: Index of the number in this tick, >= 0.
    """
    word, _ = threefry(key0, key1, np.uint64(tick), np.uint64(draw))
    # 52 bits plus a half: both ends of the interval are excluded exactly.
    return (np.float64(np.int64(word >> _TWELVE)) + 0.5) * 2.220446049250313e-16


@njit(cache=True, error_model="numpy")
def normal_quantile(p: float) -> float:
    """Return x with Phi(x) = p, relative error about 1e-16, for p in the open interval (0, 1).

    Source:
        AS 241, PPND16.
    """
    q = p - 0.5
    if abs(q) <= 0.425:
        r = 0.180625 - q * q
        above = 2.5090809287301226727e3 * r + 3.3430575583588128105e4
        above = (above * r + 6.7265770927008700853e4) * r + 4.5921953931549871457e4
        above = (above * r + 1.3731693765509461125e4) * r + 1.9715909503065514427e3
        above = (above * r + 1.3314166789178437745e2) * r + 3.3871328727963666080e0
        below = 5.2264952788528545610e3 * r + 2.8729085735721942674e4
        below = (below * r + 3.9307895800092710610e4) * r + 2.1213794301586595867e4
        below = (below * r + 5.3941960214247511077e3) * r + 6.8718700749205790830e2
        below = (below * r + 4.2313330701600911252e1) * r + 1.0
        return above * q / below
    r = p if q <= 0.0 else 1.0 - p
    r = math.sqrt(-log(r))
    if r <= 5.0:
        r = r - 1.6
        above = 7.74545014278341407640e-4 * r + 2.27238449892691845833e-2
        above = (above * r + 2.41780725177450611770e-1) * r + 1.27045825245236838258e0
        above = (above * r + 3.64784832476320460504e0) * r + 5.76949722146069140550e0
        above = (above * r + 4.63033784615654529590e0) * r + 1.42343711074968357734e0
        below = 1.05075007164441684324e-9 * r + 5.47593808499534494600e-4
        below = (below * r + 1.51986665636164571966e-2) * r + 1.48103976427480074590e-1
        below = (below * r + 6.89767334985100004550e-1) * r + 1.67638483018380384940e0
        below = (below * r + 2.05319162663775882187e0) * r + 1.0
    else:
        r = r - 5.0
        above = 2.01033439929228813265e-7 * r + 2.71155556874348757815e-5
        above = (above * r + 1.24266094738807843860e-3) * r + 2.65321895265761230930e-2
        above = (above * r + 2.96560571828504891230e-1) * r + 1.78482653991729133580e0
        above = (above * r + 5.46378491116411436990e0) * r + 6.65790464350110377720e0
        below = 2.04426310338993978564e-15 * r + 1.42151175831644588870e-7
        below = (below * r + 1.84631831751005468180e-5) * r + 7.86869131145613259100e-4
        below = (below * r + 1.48753612908506148525e-2) * r + 1.36929880922735805310e-1
        below = (below * r + 5.99832206555887937690e-1) * r + 1.0
    x = above / below
    return -x if q < 0.0 else x


@njit(cache=True, error_model="numpy")
def normal(key0: np.uint64, key1: np.uint64, tick: int, draw: int) -> float:
    """Return a number of the standard normal distribution, |x| < 8.3.

    The arguments are those of `uniform`.
    """
    return normal_quantile(uniform(key0, key1, tick, draw))
