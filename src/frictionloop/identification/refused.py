"""A refusal that has a picture: what the analysis saw when it refused."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from frictionloop.quantities import FrictionloopError


class Refused(FrictionloopError):
    """An analysis that does not return what its data cannot tell; the figure of its ``kind`` draws ``curves``."""

    def __init__(self, said: str, kind: str, curves: Mapping[str, Any]) -> None:
        super().__init__(said)
        self.kind = kind
        self.curves = dict(curves)


def pictured(refusal: FrictionloopError, said: str, kind: str, file: Path) -> Refused:
    """Return a refusal with what its analysis saw; where it had not got that far, with the channels of the file."""
    if isinstance(refusal, Refused) and refusal.curves:
        return Refused(said, kind, refusal.curves)
    return Refused(said, "recording", {"file": str(file)})
