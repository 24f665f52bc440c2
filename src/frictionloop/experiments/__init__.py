"""Experiments on friction: protocols, adaptive methods, sessions, simulated participants, analysis, export.

A protocol is a file. A session of it is a folder with one row per trial, which says what was asked, what was delivered
and whether it counts.
"""

import importlib
from typing import Any

from frictionloop.experiments.bayes import Psi, Quest
from frictionloop.experiments.dry_run import check
from frictionloop.experiments.fit import fit
from frictionloop.experiments.kept_sessions import read_trials
from frictionloop.experiments.methods import ConstantStimuli, Walk
from frictionloop.experiments.own_reach import reaches
from frictionloop.experiments.participant import Observer
from frictionloop.experiments.planning import power
from frictionloop.experiments.protocol import Protocol, read_protocol
from frictionloop.experiments.running import resume, run
from frictionloop.experiments.several import Adjustment, Interleaved
from frictionloop.experiments.staircase import Staircase
from frictionloop.experiments.study import simulate
from frictionloop.experiments.summary import fits, funnel, groups, pooled


def __getattr__(name: str) -> Any:
    """Import ``report`` when it is first used: it draws, and so lives in the room above."""
    if name != "report":
        raise AttributeError(f"module 'frictionloop.experiments' has no attribute {name!r}")
    globals()[name] = importlib.import_module("frictionloop.report.experiment").report
    return globals()[name]
