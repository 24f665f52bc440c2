"""Who answers, and what they are shown of a trial on its way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import xarray as xr

from frictionloop.experiments.participant import SimulatedParticipant
from frictionloop.experiments.sequence import Trial
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError


class Aborted(FrictionloopError):
    """A session that somebody ended; the running trial is lost."""


class Response(NamedTuple):
    """An answer, and when it was given."""

    response: str
    """One of the task's choices, or a number; empty if none came."""
    rt_s: float
    """From the end of the last stroke, on the device clock."""
    uncertainty_s: float = 0.0
    """Standard deviation of that by the mapping of clocks."""
    at_s: float | None = None
    """Host's time of the answer, which a device's engine maps to its clock; None where nobody took it."""


class Presented(NamedTuple):
    """One stroke that was presented."""

    run: xr.Dataset
    """As of `simulate`."""
    onset_s: float
    """Its start on the device clock."""
    offset_s: float
    """Its end on the device clock."""
    jump_s: float = 0.0
    """By how much clocks have jumped against each other meanwhile; such a trial does not count."""


class Live(NamedTuple):
    """The newest sample of a stroke that goes on."""

    interval: int
    """Counted from 1."""
    elapsed_s: float
    """Since the stroke's start."""
    force_n: float
    setpoint_n: float
    speed_mm_s: float
    load_n: float


class Respondent:
    """Who answers: a person at a keyboard or on a page, or a simulated participant. This one is shown nothing."""

    paced = False
    """Whether a simulated bench takes as long as a real one."""
    log: Callable[..., Any] = staticmethod(lambda event, **told: None)
    """Keeps what happens in the session's log."""

    def moves(self, system: System, trial: int, interval: int) -> System:
        """Return the system as its finger moves; a person's is as it is."""
        return system

    def finger(self, system: System, trial: int) -> System:
        """Return the system with the finger as it is before a trial; a person's is as it is."""
        return system

    def before(self, trial: Trial) -> None:
        """Show the cue, and a break if there is one before this trial."""

    def cued(self, interval: int, duration_s: float) -> None:
        """Show that a stroke begins."""

    def live(self, sample: Live) -> None:
        """Show a stroke that goes on."""

    def stroked(self, interval: int, run: xr.Dataset) -> None:
        """Show a stroke that is over."""

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Return the answer to a trial."""
        raise NotImplementedError

    def told(self, trial: Trial, row: Mapping[str, Any]) -> None:
        """Give feedback, as far as the protocol has any."""

    def plain(self, when: str) -> None:
        """Show that two plain strokes come, ``before`` or ``after`` the session, by which the finger is measured."""

    def fitted(self, factor: float) -> None:
        """Show that levels were drawn together by a factor, since the finger cannot be given them all."""

    def ended(self, why: str) -> None:
        """Show that the session is over, and why if it ended early."""


class Simulated(Respondent):
    """A simulated participant as a respondent."""

    def __init__(self, participant: SimulatedParticipant) -> None:
        self.participant = participant

    def moves(self, system: System, trial: int, interval: int) -> System:
        """Return the system as the participant moves in it."""
        return self.participant.moves(system, trial, interval)

    def finger(self, system: System, trial: int) -> System:
        """Return the system with the participant's friction, which drifts from trial to trial."""
        drift = self.participant.moisture(trial)
        friction = system.friction.model_copy(update={"nominal_n": system.friction.nominal_n * drift})
        return system.model_copy(update={"friction": friction})

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Return the participant's answer."""
        runs = [each.run for each in presented]
        return Response(*self.participant.answers(trial.number, trial.comparison, runs))
