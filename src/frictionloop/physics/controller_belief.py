"""What a controller that knows its plant believes: ``controller.model`` from plate, sensor and friction law."""

from __future__ import annotations

import math
from operator import attrgetter
from typing import Any

import numpy as np

from frictionloop.parameters.doubtful_values import AMPLITUDES, BELIEVED
from frictionloop.parameters.system import System
from frictionloop.physics.friction import amplitude_for, friction_force, is_gaussian
from frictionloop.quantities.value_checks import whole

TABLE_SIZE = 64
"""Entries of a table that no file has a size for."""


def calibrate(system: System, table_size: int = TABLE_SIZE) -> System:
    """Return a system whose controller believes in its own plant, just landed at the reference load.

    Of a law that is not equation (1) the lookup gets a table a^2(f) at even forces from g(a_max) to f0, and
    tau = ln(f0 / g(a_max)) / a_max^2 puts the clamp at these ends.

    Parameters
    ----------
    system : System
        Its friction, plate and sensor decide; the gains stay.
    table_size : int
        Entries of a table, 2 to 65536.

    Raises
    ------
    FrictionloopError
        For a size outside this range.
    """
    whole("table_size", table_size, 2, 65536)
    law, largest_um = system.friction, system.plate.max_amplitude_um
    model: dict[str, Any] = {AMPLITUDES[0].rpartition(".")[2]: largest_um, "nominal_n": law.nominal_n}
    for name, (path, _) in BELIEVED.items():
        try:
            model[name] = float(attrgetter(path)(system))
        except AttributeError:  # a sensor without a resonance
            model |= {"resonance_hz": 0.0} if name == "resonance_hz" else {}
    if is_gaussian(law):
        model |= {"susceptibility_per_um2": law.susceptibility_per_um2, "table_um2": ()}
    else:
        floor_n = float(friction_force(largest_um, law))
        square_um2 = np.square(amplitude_for(np.linspace(floor_n, law.nominal_n, table_size), law))
        square_um2[[0, -1]] = largest_um * largest_um, 0.0
        model["susceptibility_per_um2"] = math.log(law.nominal_n / floor_n) / (largest_um * largest_um)
        model |= {"table_um2": tuple(square_um2.tolist()), "table_size": table_size}
    return system.evolve({f"controller.model.{name}": value for name, value in model.items()})
