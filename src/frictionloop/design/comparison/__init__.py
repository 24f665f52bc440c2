"""Control laws compared on one bench: tuned on one population of fingers, scored on another."""

from frictionloop.design.comparison.comparison_run import ComparisonInterrupted, LawRuns, run_laws
from frictionloop.design.comparison.comparison_scores import SCORES, scores
from frictionloop.design.comparison.effect_comparison import EffectComparison, compare_effects
from frictionloop.design.comparison.law_comparison import Comparison, compare
from frictionloop.design.comparison.law_margins import margin_rows, score_rows, tidy_rows, value_of
from frictionloop.design.comparison.trial_protocol import (
    ENTRANTS,
    EVALUATION_SEED,
    SMALL,
    SPEEDS_MM_S,
    TUNING_SEED,
    Entrant,
    Overrides,
)
