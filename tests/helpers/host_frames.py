"""The first frames of a host, for boards in memory."""

from frictionloop.device.codec import encode
from frictionloop.quantities.protocol_schema import schema

NONCE = 20261124
SESSION = NONCE + 1
"""Of the first hello since reset."""


def hello() -> bytes:
    """Return the first frame of a host; its session is then `SESSION`, where no host was before."""
    return encode("hello", 0, major=schema()["protocol"]["major"], nonce=NONCE)


def heartbeat(sequence: int, session: int = SESSION) -> bytes:
    """Return the frame that keeps the loop closed."""
    return encode("heartbeat", sequence, session)
