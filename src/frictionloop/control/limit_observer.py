"""An observer of the friction limit: its logarithm, in which fingers, load and vibration are summands.

Believed, with d the binary logarithm of the limit without vibration, a the amplitude, phi = tau/ln 2 and c the
compliance of the contact (1/s0 of Dahl's law, 0 for a slider), which is told:

    L = 2^(d - phi a^2),   f' = (L - f)/T,  T = c f/v,   springs and pole of the sensor driven by f

f rises no faster than the skin is stretched. Each reading corrects d, f, springs and pole by the stationary Kalman
gains for a d that drifts (control/limit_gains), in a line over T between those of a slider and those of a slow bristle.
The command is the amplitude at which L is the set-point, a^2 = (d - log2 f_r)/phi, reached by overdrive: the loop gain
is tau/tau_believed at every force, load and speed.

That one gain is learnt, from the set-point alone. Where phi is wrong, d moves with the set-point as phi - phi_true
times a^2. With z and h what log2 f_r and d do above `SLOW_HZ`:

    phi' = phi z h / (T_l max(E z^2, e^2))   while E z^2 > e^2

The set-point is an instrument: nothing that the finger does is in it, so the loop does not bias what is learnt. phi is
between model / spread and model spread, and begins at the upper end: the loop gain then comes from below. Nothing is
learnt while the finger sticks, is off the plate, the clamp acts, or the set-point rests (`LEAST_SWING`).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from frictionloop.control.law import ForceCommand, Law, clamp_of
from frictionloop.control.limit_gains import LONGEST, limit_rows
from frictionloop.parameters import SuspendedSensor
from frictionloop.parameters.block import Number, Positive
from frictionloop.parameters.timing import Timing
from frictionloop.quantities.arithmetic import exp2, fma, log2, step
from frictionloop.sensing.force_sensor import suspension_coefficients
from frictionloop.sensing.measurement import Measurement

LOG2_E = 1.4426950408889634
SLOWEST_M_S = 0.002
"""Speed below which the contact's time constant no longer grows (the least that counts as sliding)."""
LEAST_N, MOST_N = 0.1, 2.0
"""Forces by which contact and gains are scaled (assumed: those that fingers are given, and twice as much)."""
LARGEST_UP = 0.4
"""Most that one reading may move ln L: well below 1, as f follows it in a line."""
LARGEST_N, LARGEST_LOG2 = 5.0, 5.0
"""Bounds of f and d: twice what the sensor reads, and 1/32 to 32 N."""
FASTER = 1.2
"""Rise of friction that still counts as that of the skin, over stiffness times speed (stiffnesses differ)."""
SLOW_HZ = 0.3
"""Corner below which set-point and limit teach nothing: load and moisture drift there (periods of 10 s and more)."""
MEMORY_S = 2.0
"""Of the mean square of the set-point's logarithm: two periods of a sine of 1 Hz (paper, Sec. 4.2)."""
LEAST_SWING = 0.05 * LOG2_E
"""Rms of the set-point's logarithm below which nothing is learnt: as much as roughness does to the limit's."""
WINDOW_S = 0.5
"""Of the mean square of what readings move ln L by: that of a Kalman filter is what drives its state in a period."""
STATED = 0.1
"""Rms of it up to which gains are those of this finger. Friction noise of 5 % rms, 1/f over 2500/0.2 of frequency,
changes by 5 % (2 (ln pi + 0.577 - Ci pi)/ln 12500)^(1/2) = 3.0 % in a period; three times as much is assumed."""
MOST_TAUGHT = 2.0
"""Most of z h over the mean square: of phi at its upper end it is spread - 1."""


class LimitObserverController(Timing):
    """Observer of the friction limit's logarithm that learns the susceptibility (control/limit_observer)."""

    kind: Literal["limit_observer"] = "limit_observer"
    compliance_um_per_n: Annotated[Number, Field(ge=0, le=1000)] = 50.0
    """Compliance of the contact, 1/s0 of a bristle, 0 of a slider: it is told, and not learnt."""
    bandwidth_hz: Annotated[Number, Field(gt=0, le=1e6)] = 80000.0
    """Ratio of what drives the limit to the reading's noise, as a frequency (as `Observing`), for a force of 1 N."""
    spring_noise: Annotated[Number, Field(gt=0, le=100)] = 0.5
    """What drives the springs beside friction, over what drives the limit: the more, the less springs are trusted."""
    skin_stiffness_n_m: Positive = 1000.0
    """Believed stiffness of the skin: friction rises no faster than this times the speed (as `Skin`)."""
    susceptibility_spread: Annotated[Number, Field(ge=1, le=10)] = 2.5
    """Bound of what is learnt: tau from the model's over this to the model's times this, where it begins; 1 learns not.

    2.5 is exp(2.6 x 0.35), 2.6 standard deviations of ln tau over fingers, which is assumed (physics/fingers).
    """
    learning_s: Positive = 3.0
    """Time constant T_l with which the susceptibility is learnt."""

    @property
    def overdrive(self) -> bool:
        """The amplitude command always overshoots so that the plate gets there in one period."""
        return True

    @model_validator(mode="after")
    def _one_period(self) -> Self:
        if self.delay_s * self.rate_hz > 1.0 + 1e-9:
            raise ValueError(
                f"delay_s = {self.delay_s:g} s: must be at most one control period, {1.0 / self.rate_hz:g} s, under a "
                "limit observer"
            )
        return self


class LimitState(NamedTuple):
    """Amplitudes in um, forces in N, logarithms binary; the order is what the step unpacks."""

    amplitude: float
    """Believed, at t_k."""
    command: float
    """In force at t_k where the delay is a period."""
    limit: float
    """d."""
    friction: float
    spring: float
    rate: float
    reading: float
    forward: float
    """Direction of the last reading, 1 or -1; 0 before the first one."""
    fall: float
    """phi = tau / ln 2, um^-2."""
    slow_target: float
    """log2 of the set-point below `SLOW_HZ`, and d."""
    slow_limit: float
    swing: float
    """Mean square of what the set-point's logarithm does above it."""
    stuck: float
    """1 where the skin held friction back in the last period."""
    misfit: float
    """Mean square of what readings move ln L by."""


class LimitGains(NamedTuple):
    """Decays of the believed plate, the believed sensor, gains of a reading, what is told, and the clamp."""

    decay_rest: float
    """Of the plate from the sample to the command's taking effect, and over what is left of the period."""
    decay_left: float
    a11: float
    """Springs and pole over a period, `SuspensionCoefficients`."""
    a12: float
    a21: float
    a22: float
    a31: float
    a32: float
    a33: float
    kd: float
    """Gains on ln L times the force (N/N), of a slider its friction's too; ..s: more of it per period of T."""
    kds: float
    kfs: float
    k1: float
    k1s: float
    k2: float
    k2s: float
    k3: float
    k3s: float
    compliance: float
    """um/N."""
    skin: float
    """Largest rise of friction over the way of a period, N/m."""
    most_um: float
    log2_nominal: float
    """Of the model, with ``model_fall`` its phi: u stands for an amplitude by these."""
    model_fall: float
    spread: float
    learn: float
    """1/T_l, 1/s."""
    low: float
    high: float


@step
def learnt_step(fall: float, z: float, h: float, swing: float, rate: float, spread: float, model: float) -> float:
    """phi + rate phi z h / E z^2, within model/spread to model spread."""
    taught = min(max(z * h / swing, -MOST_TAUGHT), MOST_TAUGHT)
    return min(max(fma(rate * fall, taught, fall), model / spread), model * spread)


@step
def limit_observer_step(
    state: LimitState, measurement: Measurement, setpoint_n: float, gains: LimitGains, dt: float
) -> tuple[LimitState, ForceCommand]:
    """One tick; see the module."""
    a, command, d, f, x1, x2, x3, before, fall, slow_target, slow_limit, swing, was_stuck, misfit = state
    (
        decay_rest, decay_left, a11, a12, a21, a22, a31, a32, a33, kd, kds, kfs, k1, k1s, k2, k2s, k3, k3s,
        compliance, skin, most_um, log2_nominal, model_fall, spread, learn, low, high,
    ) = gains  # fmt: skip
    y, _, speed, _, valid = measurement
    forward = 1.0 if speed >= 0.0 else -1.0
    begins, slides = before == 0.0, valid > 0.5
    sign = -1.0 if forward * before < 0.0 else 1.0
    # The sensor has settled before the first reading.
    f, x2 = y if begins else sign * f, sign * x2
    x1, x3 = y if begins else sign * x1, y if begins else sign * x3

    # The contact.
    way_um = max(abs(speed), SLOWEST_M_S) * dt * 1e6
    force = min(max(f, LEAST_N), MOST_N)
    lag_um = compliance * force
    share = way_um / (lag_um + way_um)
    lag = min(lag_um / way_um, LONGEST)
    fastest = skin * way_um * 1e-6
    stuck = was_stuck > 0.5

    # Correct by the reading. A tip that sticks shows no limit, but that it is not as high as believed.
    e = y - x3
    up = fma(kds, lag, kd) * e / force if slides & ((not stuck) | (e < 0.0)) else 0.0
    up = min(max(up, -LARGEST_UP), LARGEST_UP)
    misfit = fma(dt / WINDOW_S, fma(up, up, -misfit), misfit)
    d = min(max(fma(LOG2_E, up, d), -LARGEST_LOG2), LARGEST_LOG2)
    kf = fma(kfs, lag, kd) if slides & (not stuck) else kd
    f = min(max(fma(kf, e, f), -LARGEST_N), LARGEST_N)
    x1, x2, x3 = fma(fma(k1s, lag, k1), e, x1), fma(fma(k2s, lag, k2), e, x2), fma(fma(k3s, lag, k3), e, x3)

    # What set-point and limit do.
    target = log2(max(setpoint_n, 0.02))
    slow_target, slow_limit = target if begins else slow_target, d if begins else slow_limit
    z, h, slow = target - slow_target, d - slow_limit, 2.0 * math.pi * SLOW_HZ * dt
    slow_target, slow_limit = fma(slow, z, slow_target), fma(slow, h, slow_limit)
    swing = fma(dt / MEMORY_S, fma(z, z, -swing), swing)

    # Command.
    then = fma(decay_rest, a - command, command)
    square = (d - target) / fall
    within = min(max(square, 0.0), most_um * most_um)
    wanted = exp2(fma(-model_fall, within, log2_nominal))
    u = min(max(wanted, low), high)
    held = within if u == wanted else min(max((log2_nominal - log2(u)) / model_fall, 0.0), most_um * most_um)
    decay = decay_rest * decay_left
    command = min(max(fma(-decay, then, math.sqrt(held)) / (1.0 - decay), 0.0), most_um)

    # Learn. The limit that there is stays.
    taught = slides & (not stuck) & (swing > LEAST_SWING * LEAST_SWING) & (square == held)
    new = learnt_step(fall, z, h, swing, learn * dt, spread, model_fall) if taught else fall
    new = spread * model_fall if misfit > STATED * STATED else new
    more = (new - fall) * a * a
    d, slow_limit, fall = d + more, slow_limit + more, new

    # Go on to the next sample.
    a_next = fma(decay_left, then - command, command)
    follows = share * (exp2(fma(-fall * a_next, a_next, d)) - f)
    change = min(follows, fastest) if slides else 0.0
    mean = fma(0.5, change, f)
    s, r = x1 - mean, x3 - mean
    after = LimitState(
        a_next, command, d, f + change,
        fma(a11, s, fma(a12, x2, mean)), fma(a21, s, a22 * x2), fma(a31, s, fma(a32, x2, fma(a33, r, mean))),
        forward, fall, slow_target, slow_limit, swing, 1.0 if slides & (follows > fastest) else 0.0, misfit,
    )  # fmt: skip
    return after, ForceCommand(u, 1.0 if square != held else 0.0)


def limit_observer_gains(controller: LimitObserverController) -> LimitGains:
    """Return the gains of `limit_observer_step`.

    Raises
    ------
    FrictionloopError
        For a model without resonance, or one for which no observer settles.
    """
    c, model, dt = controller, controller.model, 1.0 / controller.rate_hz
    rest, plate = min(c.delay_s * c.rate_hz, 1.0), -2.0 * math.pi * model.plate_hz * dt
    quick, slow = limit_rows(model, c.rate_hz, c.bandwidth_hz, c.spring_noise)
    more = (slow - quick) / LONGEST
    springs = suspension_coefficients(
        SuspendedSensor(resonance_hz=model.resonance_hz, q=model.resonance_q, cutoff_hz=model.sensor_hz), dt
    )
    return LimitGains(
        math.exp(plate * rest), math.exp(plate * (1.0 - rest)),
        springs.a11, springs.a12, springs.a21, springs.a22, springs.a31, springs.a32, springs.a33,
        quick[0], more[0], more[1], quick[2], more[2], quick[3], more[3], quick[4], more[4],
        c.compliance_um_per_n, FASTER * c.skin_stiffness_n_m, model.max_amplitude_um,
        math.log2(model.nominal_n), model.susceptibility_per_um2 / math.log(2.0),
        c.susceptibility_spread, 1.0 / c.learning_s, *clamp_of(model),
    )  # fmt: skip


def limit_observer_start(controller: LimitObserverController) -> LimitState:
    """Return the state before the first reading: no vibration, the believed limit, and the largest susceptibility."""
    model = controller.model
    fall = controller.susceptibility_spread * model.susceptibility_per_um2 / math.log(2.0)
    known = {"limit": math.log2(model.nominal_n), "fall": fall}
    return LimitState(*(known.get(name, 0.0) for name in LimitState._fields))


LAW = Law(
    "limit_observer",
    limit_observer_step,
    LimitState,
    LimitGains,
    limit_observer_gains,
    limit_observer_start,
    frozen=("fall", "slow_target", "slow_limit", "swing", "stuck"),
)
