"""What a device, a finger's skin and the sense of touch leave of an effect, before anything is built."""

from frictionloop.preview.effect import Preview, preview
from frictionloop.preview.measures import Delivered
from frictionloop.preview.people import People, arrivals, people

__all__ = ["Delivered", "People", "Preview", "arrivals", "people", "preview"]
