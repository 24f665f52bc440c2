"""Gains that hold: re-tuned PI and notch, H-infinity, LQG and trackers, on a set of corners."""

from frictionloop.design.high_order import Synthesised
from frictionloop.design.hinf import design_hinf, design_lqg
from frictionloop.design.notch import Notched, retune_notch
from frictionloop.design.retune import Retuned, retune
from frictionloop.design.tracker_tuning import TrackerTuning, tune_tracker

__all__ = [
    "Notched",
    "Retuned",
    "Synthesised",
    "TrackerTuning",
    "design_hinf",
    "design_lqg",
    "retune",
    "retune_notch",
    "tune_tracker",
]
