"""A frequency response that is listed, by a stepped sine or another program: resonance of the sensor and its Q."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Finding
from frictionloop.findings.result import plain
from frictionloop.identification.frequency_response import FrequencyResponse
from frictionloop.identification.measured import measured
from frictionloop.identification.modes import Modes
from frictionloop.identification.opened import Opened, opened
from frictionloop.identification.part import Part, Rows, extra_modes, not_told
from frictionloop.identification.project import Take
from frictionloop.identification.refused import pictured
from frictionloop.identification.response_modes import response_modes
from frictionloop.quantities import FrictionloopError, must_be

UNKNOWN_SHARE = 0.01
"""Share of its size that a value of a table is taken to be off by where no coherence stands beside it (assumed)."""
LEAST = 8
"""Frequencies that a table must have."""
_NAMES = "frequency with response, real and imaginary, or magnitude and phase_deg"


def response_table(file: Opened) -> FrequencyResponse:
    """Return the response that a file lists over frequency.

    Parameters
    ----------
    file : Opened
        Channels ``frequency`` in Hz, and ``response`` (complex), ``real`` and ``imaginary``, or ``magnitude`` and
        ``phase_deg`` or ``phase_rad``; a ``coherence`` is used if it is there. A magnitude in dB is 20 log10 of it.
        Rows of one frequency are averaged, and their order does not matter. Without a phase the response is real and
        its fit goes by magnitude.

    Raises
    ------
    FrictionloopError
        For columns that are missing, fewer than eight frequencies, or values that are no numbers.
    """
    columns = {name: np.asarray(line.samples[:]) for name, line in file.picked.items()}
    if "frequency" not in columns:
        raise must_be(f"{file.where}: channels", ", ".join(columns), _NAMES)
    sizes = {name: values.size for name, values in columns.items()}
    if len(set(sizes.values())) > 1:
        raise must_be(f"{file.where}: samples of columns", sizes, "equal")
    hertz = np.asarray(columns["frequency"], dtype=float)
    values = _complex(file, columns)
    coherence = np.asarray(columns.get("coherence", np.full(hertz.size, np.nan)), dtype=float)
    fine = np.isfinite(hertz) & np.isfinite(values) & (hertz > 0)
    steps, place = np.unique(hertz[fine], return_inverse=True)
    if steps.size < LEAST:
        raise must_be(f"{file.where}: frequencies", int(steps.size), f"at least {LEAST}")
    count = np.bincount(place)
    total = np.bincount(place, values[fine].real) + 1j * np.bincount(place, values[fine].imag)
    mean = (total / count).astype(complex)
    shared = np.bincount(place, np.nan_to_num(coherence[fine], nan=1 / (1 + 2 * UNKNOWN_SHARE**2))) / count
    shared = np.clip(shared, 1e-6, 1.0)
    # No rate is told: the highest frequency stands for half of one.
    told = file.picked["magnitude" if "magnitude" in columns else "frequency"].unit
    return FrequencyResponse(
        steps, mean, shared, np.sqrt((1 - shared) / (2 * shared)), np.ones_like(steps), int(count.max()),
        2 * float(steps[-1]), told if "magnitude" in columns and told else "1",
    )  # fmt: skip


def has_phase(found: FrequencyResponse) -> bool:
    """Return whether a response is more than its magnitude."""
    return bool(np.any(np.abs(found.response.imag) > 0))


def _complex(file: Opened, columns: dict[str, NDArray[np.generic]]) -> NDArray[np.complex128]:
    if "response" in columns:
        return columns["response"].astype(complex)
    if "real" in columns and "imaginary" in columns:
        return np.asarray(columns["real"], dtype=float) + 1j * np.asarray(columns["imaginary"], dtype=float)
    if "magnitude" not in columns:
        raise must_be(f"{file.where}: channels", ", ".join(columns), _NAMES)
    size = np.asarray(columns["magnitude"], dtype=float)
    if _in_db(file):
        size = 10 ** (size / 20)
    if np.nanmin(size) < 0:
        raise must_be(f"{file.where}: magnitude", float(np.nanmin(size)), '0 or more, or unit = "dB"')
    turn = np.zeros_like(size)
    if "phase_deg" in columns:
        turn = np.deg2rad(np.asarray(columns["phase_deg"], dtype=float))
    elif "phase_rad" in columns:
        turn = np.asarray(columns["phase_rad"], dtype=float)
    scale = file.chart.channels["magnitude"].scale or 1.0
    return np.asarray(scale * size * np.exp(1j * turn))


def _in_db(file: Opened) -> bool:
    line = file.picked["magnitude"]
    said = file.chart.channels["magnitude"].unit or line.unit or line.name.rpartition(" ")[2]
    return said.strip("[]() ").lower() == "db"


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
    shift_hz = [each.method_hz[k] for each, k in zip(found, chosen, strict=True)]
    shift_q = [each.method_q[k] for each, k in zip(found, chosen, strict=True)]
    values = [
        measured("sensor.resonance_hz", hertz, shift_hz, how, take.files, date),
        measured("sensor.q", [each.asked[0].q for each in found], shift_q, how, take.files, date),
        *extra_modes(take, found[0], whole, date),
    ]
    modes, told = found[0].modes, list[Finding]()
    if not all(phased):
        told.append(not_told("the phase", "magnitudes alone"))
    numbers = {"modes_hz": [m.frequency.value for m in modes], "modes_q": [m.q.value for m in modes]}
    prints = tuple(
        {"path": name, "sha256": file.sha256, "date": take.date or file.contents.date}
        for name, file in zip(take.files, files, strict=True)
    )
    curves = _curves(tables[0], found[0])
    return Part(take.kind, prints, tuple(values), tuple(told), plain(numbers), tuple(rows), curves)


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
