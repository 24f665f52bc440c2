"""The certificate of a bench: what was measured, from which files, what is assumed, and how much that matters."""

from __future__ import annotations

import json
import math
import os
import platform
import re
import shutil
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from frictionloop.analysis import linearise, operating_band, touch_spectrum
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.loop_elements import linearise_contact
from frictionloop.design.pi_synthesis import retune
from frictionloop.figures.style import inline, svg
from frictionloop.findings.render import findings_html
from frictionloop.identification import Bench
from frictionloop.identification.project_entry_result import EntryResult, number_said
from frictionloop.parameters import FingerFriction, Strokes, System
from frictionloop.quantities import FrictionloopError, replacing, unit_of
from frictionloop.quantities.code_version import package_version
from frictionloop.report.certificate_figures import crowd, drawn
from frictionloop.report.page_templates import templates

RANGES = {
    "plate.frequency_hz": (0.95, 1.05),
    "plate.q": (0.6, 1.6),
    "plate.max_amplitude_um": (0.7, 1.3),
    "controller.delay_s": (0.7, 1.5),
    "sensor.resonance_hz": (0.7, 1.4),
    "sensor.q": (0.4, 2.5),
    "sensor.cutoff_hz": (0.5, 2.0),
    "friction.nominal_n": (0.8, 1.5),
    "friction.susceptibility_per_um2": (0.6, 1.6),
    "finger.stiffness_n_m": (0.5, 2.0),
}
"""Factors between which an unmeasured number of a preset may lie (assumed)."""


POINTS = 400
"""Frequencies of the residual's integral (its error is below a percent)."""


class Importance(NamedTuple):
    """What one assumed number does to the loop."""

    path: str
    low: float
    """Least value that it may have."""
    high: float
    peak_low: float
    """Largest sensitivity Ms with the least value; infinite if unstable, NaN if the set-point is out of reach."""
    peak_high: float
    residual_low_n: float
    """What the loop leaves of friction noise and tremor from 1 Hz on with the least value, N rms; NaN as above, or
    where nothing strokes."""
    residual_high_n: float

    @property
    def swing(self) -> float:
        """How far Ms moves, infinite if the loop can become unstable."""
        apart = abs(self.peak_high - self.peak_low)
        return apart if math.isfinite(apart) else math.inf


def importance(found: Bench) -> list[Importance]:
    """Return the assumed numbers, the most important first; none if no gains hold on the bench.

    The gains are those of `retune` on the bench as described; then one number at a time takes the ends of its range,
    the controller knowing nothing of it.

    Parameters
    ----------
    found : Bench
        From ``fl.identify.bench``.
    """
    try:
        tuned = found.system.evolve(retune(operating_band(found.system)).overrides)
    except FrictionloopError:
        return []
    rows = []
    for path, factors in RANGES.items():
        if path in found.measured or path in found.stated:
            continue
        block, name = path.split(".")
        value = float(getattr(getattr(tuned, block), name))
        ends = [value * factor for factor in factors]
        peaks, left_n = zip(*(_judged(tuned, path, end) for end in ends), strict=True)
        rows.append(Importance(path, *ends, *peaks, *left_n))
    return sorted(rows, key=lambda row: -row.swing)


def _judged(system: System, path: str, value: float) -> tuple[float, float]:
    """Return Ms and the residual in N rms with one value changed."""
    try:
        loop = linearise(system.evolve({path: value}))
    except FrictionloopError:
        return math.nan, math.nan  # the set-point is out of reach
    margins = loop.margins()
    return (margins.sensitivity_peak, _residual_n(loop)) if margins.stable else (math.inf, math.inf)


def _residual_n(loop: LinearLoop) -> float:
    """Return the rms of |S| times what moves the force behind the contact, sqrt(integral of |S|^2 |C|^2 P df)."""
    system = loop.system
    if not (isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes)):
        return math.nan
    frequency = np.geomspace(1.0, loop.nyquist_hz, POINTS)
    lag = np.abs(linearise_contact(system, loop.elements.force_n).response(frequency))
    left = touch_spectrum(system, 0.0)(frequency) * (lag * np.abs(loop.responses(frequency)["S"])) ** 2
    return math.sqrt(float(np.trapezoid(left, frequency)))


TITLES = {
    "weights": "Weights",
    "hits": "Hits",
    "response": "Frequency response",
    "quiet": "Quiet",
    "slides": "Slides",
    "load": "Load cells",
    "position": "Position",
    "scale": "Amplitude",
    "plate": "Plate",
    "carrier": "Carrier",
    "delay": "Delay",
    "amplitude": "Finger under amplitude commands",
}


def write_certificate(found: Bench, path: str | os.PathLike[str]) -> Path | None:
    """Write the certificate; an older one is kept beside it under a number. Return where the older one is.

    Parameters
    ----------
    found : Bench
        From ``fl.identify.bench``.
    path : path
        Page (.html) to write.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written.
    """
    target = Path(path)
    page = certificate(found)
    kept = None
    if target.exists():
        beside_it = (target.with_name(f"{target.stem}-{k}{target.suffix}") for k in count(1))
        kept = next(path for path in beside_it if not path.exists())
        shutil.copy2(target, kept)
    with replacing(target) as beside:
        beside.write_text(page, encoding="utf-8")
    return kept


def certificate(found: Bench) -> str:
    """Return the page: figures and tables of each measurement, the values, the files, and what is still assumed."""
    parts = [(_title(part), part, _figures(part, k)) for k, part in enumerate(found.parts)]
    return (
        templates()
        .get_template("certificate.html.jinja")
        .render(
            name=re.sub(r"\.toml$", "", found.project.name),
            version=package_version(),
            python=platform.python_version(),
            values=list(found.measured.values()),
            parts=parts,
            stated=[(name, _value(found, name), said) for name, said in found.stated.items()],
            assumed=[(name, _value(found, name), unit_of(name)) for name in found.assumed],
            important=importance(found),
            peak=lambda ms: "out of reach" if math.isnan(ms) else f"{ms:.2f}" if math.isfinite(ms) else "unstable",
            left=lambda n: f"{1e3 * n:.3g} mN" if math.isfinite(n) else "–",
            corner=found.resonance_error,
            design_flags=found.design_flags,
            corners=found.corners,
            findings=[each for each in found.findings if not any(each in part.findings for part in found.parts)],
            told=lambda some: Markup(findings_html(some)),
            number=number_said,
            range_db=found.range_db,
            crowd=None if found.people is None else Markup(inline(svg(crowd(found.people), "crowd"), "fingers")),
            held=Markup(_held(found)),
            files=[each for part in found.parts for each in part.files],
        )
    )


def _title(part: EntryResult) -> str:
    whose = part.curves.get("person")
    return TITLES[part.kind] + (f": {whose['finger']}" if whose else "")


def _held(found: Bench) -> str:
    """Return values and corners as JSON that no tag can end, for ``identify compare`` and ``design controller``."""
    values: dict[str, Any] = {"measured": [each.to_dict() for each in found.measured.values()]}
    values["corners"] = [each._asdict() for each in found.corners]
    return json.dumps(values).replace("<", "\\u003c")


def _value(found: Bench, name: str) -> Any:
    value: Any = found.system
    for word in name.split("."):
        value = getattr(value, word)
    return f"{value:.5g}" if isinstance(value, float) else value


def _figures(part: EntryResult, number: int) -> list[Markup]:
    return [
        Markup(inline(svg(figure, f"c{number}-{k}"), f"{part.kind}: {name}"))
        for k, (name, figure) in enumerate(drawn(part.kind, part.curves))
    ]
