"""State and gains of the tracker; the order is what its steps unpack."""

from __future__ import annotations

from typing import NamedTuple


class TrackerState(NamedTuple):
    """Amplitude in um, forces in N, d and the load as binary logarithms."""

    amplitude: float
    """Believed, at t_k."""
    command: float
    """Of the last tick, in force at t_k where the delay is a period."""
    limit: float
    """d: log2 of the limit in N without vibration, at the reference load."""
    trusted: float
    """d as the command uses it."""
    friction: float
    spring: float
    rate: float
    reading: float
    forward: float
    """Direction of the last reading, 1 or -1; 0 before the first one."""
    load: float
    """log2 of the load over the reference, low-passed."""
    rising: float
    """Rate of the friction, N/s, smoothed."""
    falling: float
    """By how much friction falls faster than the skin lets it rise, N/s, smoothed; slower falls count as 0."""
    friction_before: float
    compliance: float
    """Of the contact, um/N."""
    fall: float
    """tau / ln 2, um^-2."""
    power_c: float
    power_t: float
    """Mean squares of the last sensitivities of either group below."""
    leapt: float
    """1 while friction leaps down, less and less afterwards."""
    quick: float
    """Rate of the friction, N/s, smoothed less than ``rising``."""
    by_c0: float
    """By the compliance: ln of the limit, friction, springs (2) and reading; then by ``fall``."""
    by_c1: float
    by_c2: float
    by_c3: float
    by_c4: float
    by_t0: float
    by_t1: float
    by_t2: float
    by_t3: float
    by_t4: float


class SensorStep(NamedTuple):
    """x' = A x + b0 f + b1 f', exact for a force that is linear over the period."""

    a11: float
    a12: float
    a21: float
    a22: float
    a31: float
    a32: float
    a33: float
    b1: float
    b2: float
    b3: float
    c1: float
    c2: float
    c3: float


class TrackerGains(NamedTuple):
    """What the law is told besides sensor and schedule."""

    rest: float
    """Share of a period from the sample to the command's taking effect."""
    decay_rest: float
    """Of the plate over that share, over what is left, and over a whole period."""
    decay_left: float
    decay: float
    inverse: float
    """1/(1 - decay)."""
    largest_um: float
    largest_compliance: float
    learn_c: float
    learn_t: float
    load_exponent: float
    load_gain: float
    skin: float
    """N/m."""
    jump: float
    log2_nominal: float
    """Of the model, with ``model_fall`` = tau / ln 2 of it: u stands for an amplitude by these."""
    model_fall: float
    stuck_friction: float
    """Gains of an observer that knows nothing of the limit, for a tip that sticks: friction, springs (2), reading."""
    stuck_spring: float
    stuck_rate: float
    stuck_reading: float


class Column(NamedTuple):
    """One value of the schedule: the first, and slopes that add up between its places."""

    first: float
    slope_0: float
    slope_1: float
    slope_2: float
    slope_3: float
    slope_4: float
    slope_5: float
    slope_6: float
    slope_7: float
    slope_8: float


class ScheduleColumns(NamedTuple):
    """The schedule's values, in the order of its rows."""

    limit: Column
    friction: Column
    spring: Column
    rate: Column
    reading: Column
    lead: Column
    trust: Column


class TrackerTick(NamedTuple):
    """All gains of the law, and the clamp, N."""

    own: TrackerGains
    sensor: SensorStep
    schedule: ScheduleColumns
    low: float
    high: float


ESTIMATES = ("compliance", "fall", "power_c", "power_t")
"""What changes over seconds: the linear analysis holds it."""
