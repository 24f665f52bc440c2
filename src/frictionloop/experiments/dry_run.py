"""A protocol before anything starts: every branch run dry, how long it takes, who can be given its forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from frictionloop.experiments.needed import Needed, needed, share_in_reach
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.sequence import Sequence
from frictionloop.experiments.study import study_system
from frictionloop.experiments.table import scored
from frictionloop.findings import Finding, Result
from frictionloop.findings.shown import between
from frictionloop.parameters import System
from frictionloop.parameters.motion import Strokes
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.compiling import program_of
from frictionloop.rendering.track import Track

MOST_TRIALS = 20_000
"""Trials of a dry run, after which a protocol is taken to have no end (assumed)."""
ANSWER_S = 1.0
"""Time that an answer is counted with (assumed)."""
FEW = 0.25
"""Share of fingers in reach below which that is a finding (assumed)."""
PEOPLE = 200
"""Fingers that the share in reach is told of (assumed)."""


@dataclass(frozen=True, kw_only=True)
class ProtocolCheck(Result):
    """What a protocol will do."""

    SCHEMA: ClassVar[str] = "experiments.check/1"
    name: str
    title: str
    trials: tuple[int, int]
    """Trials of a session whose answers are all right, and all wrong; of one whose answers are numbers the same."""
    duration_s: float
    """Longest time of these, an answer counted with 1 s, without breaks and repetitions."""
    needed: Needed
    """Forces that it asks for."""
    share_in_reach: float
    """Share of the population's fingers that can be given all of them."""

    def rows(self) -> list[tuple[str, str]]:
        """Return trials, time, forces and the share of fingers."""
        fewest, most = sorted(self.trials)
        return [
            ("protocol", f"{self.name}: {self.title}"),
            ("trials", between(float(fewest), float(most))),
            ("takes", f"{self.duration_s / 60.0:.0f} min at most, without breaks"),
            ("forces", between(self.needed.low_n, self.needed.high_n, "N")),
            ("in reach", f"of {100 * self.share_in_reach:.0f} % of fingers"),
        ]


def check(protocol: Protocol, system: System | None = None) -> ProtocolCheck:
    """Run every branch of a protocol dry and return what it will do.

    Parameters
    ----------
    protocol : Protocol
        What is to be checked.
    system : System, optional
        The bench that it is to run on; that of `study_system` if not given.

    Raises
    ------
    FrictionloopError
        For a field of the system or the effect that is not there, an effect that does not fit the plate, a stroke that
        is longer than the plate, or a protocol without an end; naming field and trial.
    """
    base = (system or study_system()).evolve(protocol.system)
    for condition in protocol.conditions:
        try:
            own = base.evolve(condition.system)
        except FrictionloopError as error:
            raise FrictionloopError(f"conditions.{condition.name}.system: {error}") from None
        _fits(protocol, own)
        for level in {*protocol.method.extremes()}:
            try:
                program_of(protocol.stimulus.at(level, condition.effect), Track(), own.touch.load.length_mm)
            except FrictionloopError as error:
                raise FrictionloopError(f"condition {condition.name}, level {level:g}: {error}") from None
    runs = [_dry(protocol, right) for right in (True, False)]
    share = share_in_reach(protocol, base, fingers(PEOPLE, 0))
    few = [Finding("STUDY-REACH", value=100.0 * share, unit="%")] if share < FEW else []
    return ProtocolCheck(
        name=protocol.name,
        title=protocol.title,
        trials=(runs[0][0], runs[1][0]),
        duration_s=max(each[1] for each in runs),
        needed=needed(protocol),
        share_in_reach=share,
        findings=tuple(few),
    )


def _fits(protocol: Protocol, system: System) -> None:
    guide = protocol.timeline.stroke
    if not isinstance(system.motion, Strokes):
        raise FrictionloopError('motion.kind: must be "strokes"')
    if guide.length_mm > system.touch.load.length_mm:
        raise FrictionloopError(
            f"timeline.stroke.length_mm = {guide.length_mm:g}: the plate has {system.touch.load.length_mm:g} mm"
        )


def _dry(protocol: Protocol, right: bool) -> tuple[int, float]:
    """Return how many trials a session has whose answers are all right or all wrong, and how long it takes."""
    order, line = Sequence(protocol, "P01"), protocol.timeline
    trial_s = (
        line.cue_s + protocol.intervals * line.stroke.duration_s + (protocol.intervals - 1) * line.gap_s + ANSWER_S
    )
    number = 0
    while (trial := order.next()) is not None:
        number += 1
        if number > MOST_TRIALS:
            raise FrictionloopError(f"stop.trials is missing: no end after {MOST_TRIALS}")
        protocol.stimulus.at(trial.level, trial.condition.effect)
        answer = _answer(protocol, trial.level, trial.comparison, right)
        _, result = scored(protocol, trial.level, trial.comparison, answer)
        start = (number - 1) * trial_s
        order.tell(
            {
                "phase": trial.phase,
                "again": 0,
                "counted": int(trial.phase == "main"),
                "result": result,
                "delivered": trial.level,
                "onset_s": start,
                "offset_s": start + trial_s,
            }
        )
    return number, number * trial_s


def _answer(protocol: Protocol, level: float, comparison: int, right: bool) -> str:
    if not protocol.choices:
        return "50"
    if protocol.task == "adjustment":
        return "alike" if right else "more"
    found = {scored(protocol, level, comparison, each)[0]: each for each in protocol.choices}
    return found.get(1.0 if right else 0.0, protocol.choices[0])
