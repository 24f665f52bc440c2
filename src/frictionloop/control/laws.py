"""Every control law, by the kind of parameters that it runs with."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from frictionloop.control.filtered_pi import FILTERED_PI_LAW
from frictionloop.control.law import Law
from frictionloop.control.limit_observer import LAW as LIMIT_OBSERVER_LAW
from frictionloop.control.lookup import LOOKUP_LAW
from frictionloop.control.pi import PI_LAW
from frictionloop.parameters.controller import CONTROLLERS
from frictionloop.quantities import FrictionloopError

BUILT_IN = (PI_LAW, LOOKUP_LAW, FILTERED_PI_LAW, LIMIT_OBSERVER_LAW)
LAWS: dict[str, Law] = {law.kind: law for law in BUILT_IN} | {"notch_pi": FILTERED_PI_LAW}
"""By the kind of ``controller``; the notch is one section of a filtered PI."""
for _kind, _place in CONTROLLERS.beside.items():
    LAWS[_kind] = import_module(_place.partition(":")[0]).LAW


def law_of(controller: Any) -> Law:
    """Return the law that a controller's parameters are for."""
    if controller.kind not in LAWS:
        accepted = ", ".join(LAWS)
        raise FrictionloopError(f"controller.kind = {controller.kind!r}: accepted {accepted}")
    return LAWS[controller.kind]
