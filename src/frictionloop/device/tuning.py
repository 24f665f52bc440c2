"""The controller of a device by the names of a System: as it was set up, or as far as the device tells it."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.control.laws import NUMBERED
from frictionloop.device.table import Parameters
from frictionloop.firmware.compiled import controller_words
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.quantised import pi_gains
from frictionloop.firmware.words import word_of
from frictionloop.parameters import Model, PiController, System, bench
from frictionloop.quantities import FrictionloopError, must_be

TOLD = "controller.kp", "controller.ki"
"""Names that a device tells where nobody knows its System."""
DIGITS = 8
"""Of a gain that is read back: the device holds 30 bits."""
ELSE = "give the system, or upload() it"


def told_controller(parameters: Parameters, rate_hz: float) -> PiController:
    """Return the PI controller that a parameter table holds.

    Raises
    ------
    FrictionloopError
        Where it holds another law, whose words do not tell its gains.
    """
    number = int(parameters["law.number"])
    law = NUMBERED[number - 1].kind if 0 < number <= len(NUMBERED) else "none"
    if law != "pi":
        raise must_be("law", law, f"pi; {ELSE}")
    kp, ki_dt = np.asarray(parameters["law.gains"])[:2]
    kp, ki = (float(f"{gain:.{DIGITS}g}") for gain in (kp, ki_dt * rate_hz))
    return PiController(kp=kp, ki=ki, rate_hz=rate_hz, model=Model(nominal_n=parameters["law.high_n"]))


def tuned_words(base: System | PiController, values: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return the words by name of a controller with other values, of a System or as a device tells it.

    Raises
    ------
    FrictionloopError
        For a value that is unknown, out of range, or not told by the device.
    """
    if isinstance(base, System):
        tuned = base.evolve(values)
        firmware_words(tuned)  # also refuses what of the controller is not the firmware's, such as a rate
        return controller_words(tuned)
    for name in values:
        if name not in TOLD:
            raise FrictionloopError(f"{name}: accepted {', '.join(TOLD)}; {ELSE}", "NOT-CHECKED")
    controller: Any = bench().model_copy(update={"controller": base}).evolve(values).controller
    words = np.zeros(word_of("law.gains").words, np.int32)
    own = np.ravel(pi_gains(controller))
    words[: own.size] = own
    return {"law.gains": words}
