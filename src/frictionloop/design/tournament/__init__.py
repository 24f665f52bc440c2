"""Control laws compared on one bench: tuned on one population of fingers, scored on another."""

from frictionloop.design.tournament.entrants import ENTRANTS, Entrant
from frictionloop.design.tournament.limits import StepLimits, step_limits
from frictionloop.design.tournament.protocol import (
    EVALUATION_SEED,
    SMALL,
    SPEEDS_MM_S,
    TUNING_SEED,
    tuning_population,
)
from frictionloop.design.tournament.run import Tournament, TournamentInterrupted, compare
from frictionloop.design.tournament.scores import SCORES, BelowOracle, below_oracle, scores
from frictionloop.design.tournament.table import margin_rows, score_rows, tidy_rows, value_of
from frictionloop.design.tournament.why import check_laws, reason_rows, reasons

__all__ = [
    "BelowOracle",
    "ENTRANTS",
    "EVALUATION_SEED",
    "Entrant",
    "SCORES",
    "SMALL",
    "SPEEDS_MM_S",
    "StepLimits",
    "TUNING_SEED",
    "Tournament",
    "TournamentInterrupted",
    "below_oracle",
    "check_laws",
    "compare",
    "margin_rows",
    "score_rows",
    "scores",
    "step_limits",
    "tidy_rows",
    "tuning_population",
    "value_of",
    "reason_rows",
    "reasons",
]
