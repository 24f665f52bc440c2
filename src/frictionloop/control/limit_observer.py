"""Steps of the tracker's observer: correct what is believed by a reading, and go on to the next.

Believed: the limit L = 2^(d + n l - (tau/ln 2) a^2) of the friction under amplitude a and load l, friction f that
follows it, and the sensor behind it. With c the compliance of the contact (1/s0 of Dahl's law, 0 for a slider):

    f' = (L - f) / (1 + c f / (v dt)) per period, rising no faster than k v
"""

from __future__ import annotations

from frictionloop.quantities.arithmetic import exp2, fma, step

LEAST_N = 0.05
"""Limit below which the contact's time constant no longer falls (assumed)."""


QUICK_M_S = 9.0 / 128.0
"""Speed above which gains are taken from the quick end of the schedule: 70 mm/s (chosen on fingers(240, 23):
from 53 to 57 mm/s a slider has with these gains a line at 850 to 900 Hz with a tenth of the variance, from 70 a
twentieth)."""


@step
def place_of(share: float, speed_m_s: float) -> float:
    """Where gains are taken from the schedule (parameters.tracking.PLACES): by share and speed.

    At the share that a stroke at 80 mm/s has at 0.8 N, one at 20 mm/s has 0.2 N; it is felt less, and as little of the
    susceptibility is believed there, its loop has twice the gain: they bear other rows. A slow stroke goes up the
    schedule with its share, a slider's beyond 0.75 the sooner the faster it is; a quick one comes from the other end.
    """
    beyond = max(share - 0.75, 0.0)
    slow = share - beyond + min(beyond * max(50.0 * speed_m_s, 1.0), 0.5)
    return 2.0 - min(max(share, 0.125), 0.75) if speed_m_s > QUICK_M_S else slow


@step
def scheduled(place: float, column) -> float:  # type: ignore[no-untyped-def]
    """Line by line between the places 0.07, 0.125, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75 and 1.875; slopes add up."""
    first, s0, s1, s2, s3, s4, s5, s6, s7, s8 = column
    v = fma(s0, max(place - 0.07, 0.0), first)
    v = fma(s1, max(place - 0.125, 0.0), v)
    v = fma(s2, max(place - 0.25, 0.0), v)
    v = fma(s3, max(place - 0.5, 0.0), v)
    v = fma(s4, max(place - 0.75, 0.0), v)
    v = fma(s5, max(place - 1.0, 0.0), v)
    v = fma(s6, max(place - 1.25, 0.0), v)
    v = fma(s7, max(place - 1.5, 0.0), v)
    return fma(s8, max(place - 1.75, 0.0), v)


@step
def share_of(compliance_um_per_n: float, limit_n: float, way_um: float) -> float:
    """1 / (1 + c L / (v dt)): share of the way to its limit that friction goes while the finger goes v dt."""
    return 1.0 / fma(compliance_um_per_n * max(limit_n, LEAST_N), 1.0 / way_um, 1.0)


@step
def limit_of(limit_log2: float, fall: float, amplitude_um: float) -> float:
    """L = 2^(d - (tau/ln 2) a^2) in N."""
    return exp2(fma(-fall * amplitude_um, amplitude_um, limit_log2))


@step
def stuck_share(friction_n: float, limit_n: float, rising_n_s: float, fastest_n_s: float, valid: float) -> float:
    """How much friction looks stuck: 0 within 10 % of its limit, 1 from 20 % below it on, if it rises as the skin does.

    Friction that does not rise is at a limit below the believed one, and has to correct it: held back by its own
    belief an observer would wait for ever.
    """
    below = 1.0 - friction_n / max(limit_n, 0.02)
    w = min(max(fma(10.0, below, -1.0), 0.0), 1.0)
    w = 0.0 if rising_n_s < 0.25 * fastest_n_s else w
    return 1.0 if (friction_n < 0.0) | (valid == 0.0) else w


@step
def sensor_step(  # type: ignore[no-untyped-def]
    spring: float, rate: float, reading: float, friction_n: float, next_n: float, s
) -> tuple[float, float, float]:
    """Springs and pole a period on, exactly, for a force that goes from f to f' in a line."""
    a11, a12, a21, a22, a31, a32, a33, b1, b2, b3, c1, c2, c3 = s
    return (
        fma(a11, spring, fma(a12, rate, fma(b1, friction_n, c1 * next_n))),
        fma(a21, spring, fma(a22, rate, fma(b2, friction_n, c2 * next_n))),
        fma(a31, spring, fma(a32, rate, fma(a33, reading, fma(b3, friction_n, c3 * next_n)))),
    )


@step
def sensitivity_step(  # type: ignore[no-untyped-def]
    state, keep: float, gains, stuck: float, share: float, limit_n: float, added: float, s
) -> tuple[float, float, float, float, float]:
    """How the observer would differ at the next sample, were a parameter larger by one: the same observer, linearised.

    The first of the state is that of ln L, as is its gain: a limit that falls with vibration takes its error along.
    ``added`` is what the parameter itself adds to friction in the period; ``keep`` is 0 at a turn: it begins anew.
    """
    d, f, x1, x2, x3 = state
    d, f, x1, x2, x3 = keep * d, keep * f, keep * x1, keep * x2, keep * x3
    kd, kf, k1, k2, k3 = gains
    error, slides = -x3, 1.0 - stuck
    d = fma(slides * kd, error, d)
    f = fma(slides * kf, error, f)
    x1, x2, x3 = fma(k1, error, x1), fma(k2, error, x2), fma(k3, error, x3)
    after = fma(share, fma(limit_n, d, -f), f) + added
    x1, x2, x3 = sensor_step(x1, x2, x3, f, after, s)
    return d, after, x1, x2, x3
