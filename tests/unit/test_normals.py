"""Counter-based noise: Random123's known answers, an independent Philox, and what independent normals must show."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numba import njit
from scipy import stats

from frictionloop.quantities.counter_noise import BLOCK, covariance_root, normals, philox

word = st.integers(0, 2**32 - 1)

# Random123's kat_vectors for philox4x32-10: counter, key, result. The last counter and key are digits of pi.
KNOWN = [
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]


@njit
def compiled_philox(c, k):
    return philox(c[0], c[1], c[2], c[3], k[0], k[1])


def ours(counter, key):
    return tuple(int(w) for w in compiled_philox(np.array(counter, np.uint64), np.array(key, np.uint64)))


def philox4x32_10(counter, key):
    """Philox as the paper of Salmon et al. (2011) writes it: (L, R) -> (mulhi(R, M) ^ k ^ L, mullo(R, M))."""
    r0, l0, r1, l1 = counter  # the paper's two Feistel halves, interleaved with a permutation
    k0, k1 = key
    for _ in range(10):
        high0, low0 = divmod(0xD2511F53 * r0, 2**32)
        high1, low1 = divmod(0xCD9E8D57 * r1, 2**32)
        r0, l0, r1, l1 = high1 ^ l0 ^ k0, low1, high0 ^ l1 ^ k1, low0
        k0, k1 = (k0 + 0x9E3779B9) % 2**32, (k1 + 0xBB67AE85) % 2**32
    return r0, l0, r1, l1


def words(text):
    return tuple(int(w, 16) for w in text.split())


@pytest.mark.parametrize(("counter", "key", "result"), KNOWN)
def test_known_answers(counter, key, result):
    assert ours(words(counter), words(key)) == words(result)
    assert philox4x32_10(words(counter), words(key)) == words(result)


@given(st.tuples(word, word, word, word), st.tuples(word, word))
def test_philox_equals_the_independent_one(counter, key):
    assert ours(counter, key) == philox4x32_10(counter, key)


def independent_normals(seed, stream, start, stop):
    """Draw with Python's integers and libm, from the layout the module describes."""
    out = []
    for period in range(start, stop):
        block, within = divmod(period, 32)
        m, c = divmod(within, 8)  # one draw serves periods c, c+8, c+16 and c+24 of a block
        counter = 8 * block + c
        w = philox4x32_10((counter % 2**32, counter >> 32, stream, 0), (seed % 2**32, seed >> 32))
        w0, w1 = w[:2] if m < 2 else w[2:]
        radius, angle = math.sqrt(-2 * math.log((w0 + 0.5) / 2**32)), 2 * math.pi * w1 / 2**32
        out.append(radius * (math.cos(angle) if m % 2 == 0 else math.sin(angle)))
    return np.array(out)


@given(seed=st.integers(0, 2**64 - 1), stream=word, start=st.integers(0, 2**34), count=st.integers(1, 70))
@example(seed=2**64 - 1, stream=2**32 - 1, start=2**34 - 5, count=10)  # the counter passes 2**32
def test_normals_equal_the_independent_ones(seed, stream, start, count):
    # |z| < 6.8 and its angle is good to 2 pi 2^-53 turns of rounding: 6.8 * 7e-16 and a few ulp stay below 1e-14.
    # Where the radius is small (w0 near 2^32) ln is ill-conditioned for both: its error 1e-16 is divided by the
    # radius, at least 1e-5, so 1e-11.
    expected = independent_normals(seed, stream, start, start + count)
    np.testing.assert_allclose(normals(seed, stream, start, start + count), expected, rtol=0, atol=1e-11)


@given(st.integers(0, 2**40), st.lists(st.integers(0, 100), min_size=1, max_size=6), st.integers(0, 2**64 - 1))
def test_any_chunks_give_the_same_bits(start, sizes, seed):
    edges = start + np.cumsum([0, *sizes])
    parts = [normals(seed, 3, int(a), int(b)) for a, b in itertools.pairwise(edges)]
    np.testing.assert_array_equal(np.concatenate(parts), normals(seed, 3, int(edges[0]), int(edges[-1])))


def test_an_empty_range_has_no_normals():
    assert normals(0, 0, 5, 5).shape == (0,)
    assert BLOCK == 32  # what the layout above assumes


N = 1_000_000
MANY = normals(12345, 0, 0, N)
# A correct generator passes each test below with probability 1 - 1e-6 for a seed nobody chose; the seed is fixed.
SIGMAS = 4.9  # two-sided 1e-6


def test_moments():
    # Standard errors of the first moments of N normals: 1, sqrt 2, sqrt 6, sqrt 24 over sqrt N (Kendall and Stuart).
    assert abs(MANY.mean()) < SIGMAS / math.sqrt(N)
    assert abs(MANY.var() - 1) < SIGMAS * math.sqrt(2 / N)
    assert abs(stats.skew(MANY)) < SIGMAS * math.sqrt(6 / N)
    assert abs(stats.kurtosis(MANY)) < SIGMAS * math.sqrt(24 / N)


def test_distribution():
    assert stats.kstest(MANY, "norm").pvalue > 1e-6
    # Tails: 32-bit words allow |z| up to sqrt(2 ln 2^33) = 6.76 and no further.
    assert 4.0 < np.abs(MANY).max() < 6.77
    beyond = np.count_nonzero(np.abs(MANY) > 3)
    expected = N * 2 * stats.norm.sf(3)
    assert abs(beyond - expected) < SIGMAS * math.sqrt(expected)


@pytest.mark.parametrize("lag", [1, 7, 8, 9, 16, 24, 31, 32])
def test_no_correlation_in_time(lag):
    # Lags 8, 16 and 24 join normals made from the same counter.
    correlation = np.mean(MANY[lag:] * MANY[:-lag])
    assert abs(correlation) < SIGMAS / math.sqrt(N - lag)
    # Radius and angle of Box-Muller shared by two normals would show in the squares.
    squares = np.mean((MANY[lag:] ** 2 - 1) * (MANY[:-lag] ** 2 - 1)) / 2
    assert abs(squares) < SIGMAS / math.sqrt(N - lag)


@pytest.mark.parametrize(("seed", "stream"), [(12346, 0), (12345, 1), (12345 + 2**32, 0), (12345, 2), (0, 0)], ids=str)
def test_other_seeds_and_streams_are_independent(seed, stream):
    other = normals(seed, stream, 0, N)
    assert not np.any(other[:100] == MANY[:100])
    assert abs(np.mean(other * MANY)) < SIGMAS / math.sqrt(N)
    assert abs(np.mean((other**2 - 1) * (MANY**2 - 1))) / 2 < SIGMAS / math.sqrt(N)


def test_the_spectrum_is_white():
    # Periodogram ordinates of N white samples are exponential with mean 1 (Brockwell and Davis, ch. 10).
    power = np.abs(np.fft.rfft(MANY)[1:-1]) ** 2 / N
    assert stats.kstest(power, "expon").pvalue > 1e-6


@given(arrays(float, (3, 3), elements=st.floats(-2, 2)), st.tuples(*[st.sampled_from([-1.0, 1.0])] * 3))
def test_correlated_normals_do_not_hang_on_the_signs_of_eigenvectors(factor, signs):
    """Which LAPACK leaves open: builds of it for other processors give others."""
    covariance = factor @ factor.T
    powers, directions = np.linalg.eigh(covariance)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.linalg, "eigh", lambda _: (powers, directions * signs))
        root = covariance_root(covariance)
    np.testing.assert_allclose(root, covariance_root(covariance), atol=1e-12)
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)
