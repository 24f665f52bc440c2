"""A listed frequency response of a project: the resonance of the sensor and its Q."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.identification.frequency_response import FrequencyResponse
from frictionloop.identification.measured import measured
from frictionloop.identification.mode import Modes
from frictionloop.identification.opened import opened
from frictionloop.identification.parts.part import Part, Rows, extra_modes
from frictionloop.identification.project import Take
from frictionloop.identification.refused import pictured
from frictionloop.identification.response_modes import response_modes
from frictionloop.identification.response_table import has_phase, response_table
from frictionloop.quantities import FrictionloopError


def response_part(take: Take, folder: Path) -> Part:
    """Return resonance and Q of the chosen mode of each file, and how the response was fitted.

    Raises ``FrictionloopError`` for what a file or the fit refuses, naming the file.
    """
    files = [opened(folder / name, take.chart(folder), table=True) for name in take.files]
    tables = [response_table(file) for file in files]
    phased = [has_phase(each) for each in tables]
    found = []
    for name, table, phase in zip(take.files, tables, phased, strict=True):
        try:
            found.append(response_modes(table, take.mode, take.band_hz, magnitude=not phase))
        except FrictionloopError as refused:
            raise pictured(refused, f"{name}: {refused}", take.kind, folder / name) from None
    date = take.date or files[0].contents.date
    chosen = [each.chosen[0] for each in found]
    whole = f"listed response of {sum(t.frequency_hz.size for t in tables)} frequencies"
    how = f"{take.mode} mode of a {whole}"
    rows: Rows = [("file", "mode (Hz)", "Q", "share of the peaks", "misfit")]
    for name, each in zip(take.files, found, strict=True):
        rows += [
            (name, str(mode.frequency), str(mode.q), f"{mode.share:.0%}", f"{each.misfit:.1%}") for mode in each.modes
        ]
    hertz = [each.asked[0].frequency for each in found]
    values = [
        measured(
            "sensor.resonance_hz",
            hertz,
            [each.method_hz[k] for each, k in zip(found, chosen, strict=True)],
            how,
            take.files,
            date,
        ),
        measured(
            "sensor.q",
            [each.asked[0].q for each in found],
            [each.method_q[k] for each, k in zip(found, chosen, strict=True)],
            how,
            take.files,
            date,
        ),
        *extra_modes(take, found[0], whole, date),
    ]
    told = [f"modes: {', '.join(f'{mode.frequency.value:.5g} Hz' for mode in found[0].modes)}; the {take.mode} is used"]
    if not all(phased):
        told.append("no phase is listed: the fit goes by the magnitude alone")
    prints = tuple(
        {"path": name, "sha256": file.sha256, "date": take.date or file.contents.date}
        for name, file in zip(take.files, files, strict=True)
    )
    return Part(take.kind, prints, tuple(values), tuple(told), tuple(rows), _curves(tables[0], found[0]))


def _curves(table: FrequencyResponse, found: Modes) -> dict[str, Any]:
    return {
        "response": {
            "frequency_hz": table.frequency_hz.tolist(),
            "magnitude": np.abs(table.response).tolist(),
            "coherence": table.coherence.tolist(),
            "fitted_hz": [hertz for hertz, _ in found.fitted],
            "fitted": [size for _, size in found.fitted],
        },
        "poles": [(pole.order, pole.frequency_hz, pole.stable) for pole in found.diagram],
        "modes_hz": [mode.frequency.value for mode in found.modes],
    }
