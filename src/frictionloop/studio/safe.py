"""Who may talk to the studio: this machine alone, or who has the token; no other page of the browser."""

from __future__ import annotations

import hmac
import secrets
from typing import NamedTuple
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "worker-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class Doors(NamedTuple):
    """What a request must bring: a Host of these, and a token where there is one."""

    hosts: tuple[str, ...] = LOOPBACK
    """Names that the page may be asked for by, without their port; empty: any, behind a token."""
    token: str = ""
    """Lets its bearer drive; empty: nobody needs one."""
    watch_token: str = ""
    """Lets its bearer watch."""

    def role(self, request: HTTPConnection) -> str:
        """Return ``"drive"`` or ``"watch"``, or an empty text for who may not come in."""
        host = request.headers.get("host", "")
        if self.hosts and _name(host) not in self.hosts:
            return ""
        origin = request.headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return ""
        if not self.token:
            return "drive"
        given = request.query_params.get("token", "")
        if hmac.compare_digest(given.encode(), self.token.encode()):
            return "drive"
        return "watch" if hmac.compare_digest(given.encode(), self.watch_token.encode()) else ""


def _name(host: str) -> str:
    return host if host.endswith("]") else host.rpartition(":")[0] or host


def open_to_network() -> Doors:
    """Return the doors of a studio that other machines reach: any name, with tokens of 128 bit."""
    return Doors((), secrets.token_urlsafe(16), secrets.token_urlsafe(16))
