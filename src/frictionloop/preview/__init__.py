"""What a device, a finger's skin and the sense of touch leave of an effect, before anything is built."""

from frictionloop.preview.effect_preview import Preview, preview
from frictionloop.preview.effect_runs import Check, Played, check, play
from frictionloop.preview.pattern_arrival import People, arrivals, people
from frictionloop.preview.pattern_measures import Delivered

__all__ = ["Check", "Delivered", "People", "Played", "Preview", "arrivals", "check", "people", "play", "preview"]
