"""Gains that hold: re-tuned PI and notch, H-infinity and LQG, on a set of corners."""

from frictionloop.design.hinf import design_hinf, design_lqg
from frictionloop.design.notch import Notched, retune_notch
from frictionloop.design.retune import Retuned, retune
from frictionloop.design.sections import Synthesised
