"""Gains that hold: re-tuned PI and notch, and H-infinity, on a set of corners."""

from frictionloop.design.hinf import Synthesised, design_hinf
from frictionloop.design.notch import Notched, retune_notch
from frictionloop.design.retune import Retuned, retune
