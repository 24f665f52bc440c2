"""What a device, a finger's skin and the sense of touch leave of an effect, before anything is built."""

from frictionloop.preview.arrivals import People, arrivals, people
from frictionloop.preview.effect_preview import Preview, preview
from frictionloop.preview.effect_runs import Check, Played, check, play
from frictionloop.preview.measures import Delivered

__all__ = ["Check", "Delivered", "People", "Played", "Preview", "arrivals", "check", "people", "play", "preview"]
