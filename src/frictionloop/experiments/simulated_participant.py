"""A simulated participant: a finger that moves, a sense of touch that decides, and errors of both.

Nothing here was fitted to a person; numbers without a source are assumed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from scipy.signal import sosfilt

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.psychometric import JND_Z
from frictionloop.experiments.respondent import Presented, Respondent, Response
from frictionloop.experiments.trial_records import force_of, rate_of
from frictionloop.experiments.trial_sequence import Trial
from frictionloop.loop.record import system_of
from frictionloop.parameters import Skin, System
from frictionloop.parameters.block import Block, NotNegative, Number, Positive
from frictionloop.parameters.motion import Strokes
from frictionloop.perception import force_threshold_n, weighting_sos
from frictionloop.quantities import Array
from frictionloop.rendering.effect import Effect, Track
from frictionloop.rendering.effect_toml import changed

UNCLEAR, FAINTEST = 0.5, 1e-3
"""Spread of a spacing at the threshold of its pattern, relative, and the least strength that it grows to (assumed)."""


def weigh(force: Array, keep: Array, rate_hz: float, skin: Skin) -> Array:
    """Return the scored part of a force in units of its threshold, its straight line taken off."""
    part = force[keep]
    index = np.arange(part.size)
    line = np.polynomial.Polynomial.fit(index, part, 1)
    return np.asarray(sosfilt(weighting_sos(rate_hz, skin), part - line(index)))


def strength_of_period(weighted: Array, place_mm: Array, period_mm: float) -> float:
    """Return the rms of what of a weighted force repeats with a period, wherever it begins."""
    return math.sqrt(2.0) * abs(complex(np.mean(weighted * np.exp(2j * math.pi * place_mm / period_mm))))


def strength_along(weighted: Array, known: Array) -> float:
    """Return the rms of what of a weighted force goes along with a known one, |f.g| / (|g| sqrt n); 0 without that."""
    size = float(np.linalg.norm(known))
    return abs(float(weighted @ known)) / (size * math.sqrt(known.size)) if size > 0.0 else 0.0


def asked_along(effect: Effect, run: xr.Dataset) -> Array:
    """Return the force that an effect asks for along a stroke, N."""
    along, speed, load, time = (run[name].values for name in ("position", "speed", "load", "time"))
    return np.asarray(effect.force_of(Track().touch(1e3 * along, 1e3 * speed, load, time)), float)


SHORTEST_MM, LONGEST_MM = 0.5, 12.0
"""Spacings that a finger tells apart (assumed)."""


def felt_spacing_mm(weighted: Array, place_mm: Array) -> float:
    """Return the spacing at which a weighted force repeats most: the peak of its spectrum over place."""
    order = np.argsort(place_mm)
    x = np.linspace(place_mm.min(), place_mm.max(), 2048)
    even = np.interp(x, place_mm[order], weighted[order]) * np.hanning(x.size)
    power = np.abs(np.fft.rfft(even, 8 * x.size)) ** 2
    per_mm = np.fft.rfftfreq(8 * x.size, x[1] - x[0])
    inside = (per_mm >= 1.0 / LONGEST_MM) & (per_mm <= 1.0 / SHORTEST_MM)
    return float(1.0 / per_mm[inside][int(np.argmax(power[inside]))])


ROOM = 1.6
"""Way of a simulated stroke over that asked for, so that a quick finger does not turn before the end (assumed)."""


class Observer(Block):
    """How a participant decides and moves."""

    weber: Positive = 0.11
    """JND of a friction force over it, at 75 % right (0.11: Gueorguiev 2017)."""
    pattern_weber: Positive = 0.3
    """The same of the strength of a pattern (0.2 to 0.58: Forta 2012; 0.3 is assumed)."""
    spacing_weber: Positive = 0.06
    """The same of the spacing of a pattern (assumed)."""
    criterion: Number = 0.0
    """Lean towards the second interval, or towards yes, in standard deviations of the decision (assumed)."""
    lapse: NotNegative = 0.02
    """Share of trials answered without attending (assumed)."""
    same_within: Positive = 1.0
    """Difference below which two are called the same, or a setting is left, in standard deviations (assumed)."""
    exponent: Positive = 0.8
    """Exponent of the magnitude that is told over the force (assumed)."""
    magnitude_spread: NotNegative = 0.15
    """Spread of the logarithm of a told magnitude (assumed)."""
    speed_spread: NotNegative = 0.1
    """Spread of the logarithm of the speed from stroke to stroke (assumed)."""
    load_spread: NotNegative = 0.1
    """The same of the load (assumed)."""
    moisture_drift: NotNegative = 0.01
    """Spread of the step of the friction's logarithm from trial to trial, a random walk (assumed)."""
    reaction_s: Positive = 0.6
    """Median response time; its logarithm spreads by 0.3 (assumed)."""


class SimulatedParticipant(Respondent):
    """A person of the population with an observer's decisions; all that is drawn depends on seed, trial and role alone.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    finger : mapping
        Overrides of the system, as from ``fl.fingers``.
    seed : int
        Seed of the decisions and the motor errors.
    observer : Observer, optional
        How the participant decides.
    """

    def __init__(
        self, protocol: Protocol, finger: Mapping[str, Any], seed: int = 0, observer: Observer | None = None
    ) -> None:
        self.protocol, self.observer = protocol, observer or Observer()
        self._finger, self._seed = finger, seed

    def _rng(self, trial: int, role: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, trial, role])

    def finger(self, system: System, trial: int) -> System:
        """Return the system with the friction of the finger in a trial: a random walk of its logarithm."""
        steps = np.random.default_rng([self._seed, 3]).normal(0.0, self.observer.moisture_drift, trial + 1)
        nominal_n = system.friction.nominal_n * math.exp(float(steps.sum()))
        return system.model_copy(update={"friction": system.friction.model_copy(update={"nominal_n": nominal_n})})

    def moves(self, system: System, trial: int, interval: int) -> System:
        """Return the system with the finger, as the participant moves it in one interval of a trial."""
        o, guide = self.observer, self.protocol.timeline.stroke
        speed_z, load_z = self._rng(trial, 10 + interval).normal(size=2)
        motion = system.motion
        assert isinstance(motion, Strokes)
        moved = motion.model_copy(
            update={
                "speed_mm_s": guide.speed_mm_s * math.exp(o.speed_spread * speed_z),
                "stroke_mm": guide.length_mm * (1.0 if guide.direction == "both" else ROOM),
                "start": 0.5 if guide.direction == "back" else 0.0,
                "load_n": motion.load_n * math.exp(o.load_spread * load_z),
            }
        )
        return self.finger(system, trial).model_copy(update={"motion": moved})

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Return the answer to what was felt."""
        return Response(*self.answers(trial.number, trial.comparison, [each.run for each in presented]))

    def answers(self, trial: int, comparison: int, runs: list[xr.Dataset]) -> tuple[str, float]:
        """Return the answer to what was felt in the intervals of a trial, and its time from the last one's end, s."""
        rng = self._rng(trial, 1)
        rt = self.observer.reaction_s * math.exp(0.3 * rng.normal())
        felt = [self.percept(run) for run in runs]
        noisy = [value + sd * rng.normal() for value, sd in felt]
        lapsed = rng.random() < self.observer.lapse
        return self._answer(noisy, felt, comparison, lapsed, rng), rt

    def _answer(
        self,
        noisy: list[float],
        felt: list[tuple[float, float]],
        comparison: int,
        lapsed: bool,
        rng: np.random.Generator,
    ) -> str:
        task, choices, o = self.protocol.task, self.protocol.choices, self.observer
        if lapsed and choices:
            return choices[int(rng.integers(len(choices)))]
        sd = math.sqrt(sum(each[1] ** 2 for each in felt))
        if task in ("2ifc", "2afc"):
            return choices[int(noisy[1] - noisy[0] + o.criterion * sd > 0.0)]
        if task == "same_different":
            return choices[int(abs(noisy[1] - noisy[0]) > (o.same_within - o.criterion) * sd)]
        if task == "yes_no":
            # A pattern is told from one threshold on; of another attribute, what is above the standard.
            standard = 1.0 if self.protocol.attribute == "pattern" else self.protocol.stimulus.standard or 0.0
            return choices[int(noisy[0] + o.criterion * sd <= standard)]
        if task == "adjustment":
            apart = (noisy[comparison - 1] - noisy[2 - comparison]) / sd
            return choices[2] if abs(apart) < o.same_within else choices[int(apart < 0.0)]
        # A feeling has no sign: its logarithm is normal, with the same spread over its size.
        feeling, spread = felt[0]
        noise = math.sqrt(math.log1p((spread / feeling) ** 2)) * (noisy[0] - feeling) / spread if feeling > 0.0 else 0.0
        told = o.exponent * (math.log(max(feeling, FAINTEST)) + noise) + o.magnitude_spread * rng.normal()
        return f"{100.0 * math.exp(told):.4g}"

    @cached_property
    def skin(self) -> Skin:
        """The participant's fingertip, by whose stiffness thresholds of force follow from those of displacement."""
        own = {name.removeprefix("finger."): value for name, value in self._finger.items() if name[:7] == "finger."}
        return Skin(**own)

    def percept(self, run: xr.Dataset) -> tuple[float, float]:
        """Return what a stroke feels like, and the standard deviation of that feeling.

        friction: the mean force F, with sqrt((w F)^2 + F_th(1 Hz)^2). pattern: its strength D in units of its
        threshold, with sqrt(1 + (w D)^2); the participant knows the pattern, and takes no other force for it. spacing:
        where the force, weighted by the thresholds, repeats; one below
        threshold is guessed.
        """
        force, keep = run[force_of(run)].values, run["scored"].values
        scale = 1.0 / (math.sqrt(2.0) * JND_Z)  # of a JND in two intervals to the spread of one
        if not keep.any():
            return 0.0, 1.0
        if self.protocol.attribute == "friction":
            mean = float(force[keep].mean())
            return mean, math.hypot(scale * self.observer.weber * mean, float(force_threshold_n(1.0, self.skin)))
        weighted, place = weigh(force, keep, rate_of(run), self.skin), 1e3 * run["position"].values[keep]
        if self.protocol.attribute == "pattern":
            strength = self._strength(run, weighted, place)
            return strength, math.hypot(1.0, scale * self.observer.pattern_weber * strength)
        spacing = felt_spacing_mm(weighted, place)
        clear = max(float(np.sqrt(np.mean(weighted**2))), FAINTEST)
        return spacing, spacing * math.hypot(scale * self.observer.spacing_weber, UNCLEAR / clear)

    def _strength(self, run: xr.Dataset, weighted: Array, place_mm: Array) -> float:
        """Return how strong the pattern is in a weighted force: of one with a period wherever it begins."""
        effect, protocol = system_of(run).setpoint.effect, self.protocol  # type: ignore[attr-defined]
        if effect.period_mm:
            return strength_of_period(weighted, place_mm, effect.period_mm)
        level = max(protocol.method.extremes(), key=abs)
        most = changed(effect, {protocol.stimulus.field: protocol.stimulus.value(level)})
        known = weigh(asked_along(most, run), run["scored"].values, rate_of(run), self.skin)
        return strength_along(weighted, known)
