"""What a device, a finger's skin and the sense of touch leave of an effect, before anything is built."""

from frictionloop.preview.arrivals import arrivals
from frictionloop.preview.effect_preview import Preview, preview
from frictionloop.preview.effect_runs import Check, Played, check, play
from frictionloop.preview.measures import Delivered
from frictionloop.preview.people import People, people

__all__ = ["Check", "Delivered", "People", "Played", "Preview", "arrivals", "check", "people", "play", "preview"]
