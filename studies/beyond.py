"""The laws of the report's "Beyond the paper", on 26 fingers that none of them was tuned on: two minutes.

``python -m studies.beyond`` runs them at 20 mm/s and writes what the report shows into the package
(``src/frictionloop/report/stored``). It shows it until this is run again.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from frictionloop.control.instruction_cost import worst_tick
from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import law_margins, trial_protocol
from frictionloop.design.comparison.law_margins import LEVEL_N, step_traces
from frictionloop.design.comparison.trial_protocol import ENTRANTS, designed, on_device
from frictionloop.design.requirements import Requirements
from frictionloop.quantities.code_version import package_version
from frictionloop.report import control_law_study
from frictionloop.report.control_law_study import SPEED_MM_S
from frictionloop.report.paper_protocol import the_bench
from studies.laws import over_oracle
from studies.linear_reach import linear_reach_table
from studies.oracle import STAND_IN, deciding

WINDOWS_S = ((0.99, 1.06), (1.49, 1.60))
"""What is kept of a step down and of one up."""
PEAK = 2.0
"""Largest |S| that the computed limit allows."""
OF = ("lookup", "printed_pi", "retuned_pi")
LAWS = {name: ENTRANTS[entrant] for name, entrant in zip(control_law_study.LAWS, OF, strict=False)}
LAWS[control_law_study.NOTCH] = designed("notch_pi", Requirements(slip_lengths_um=()))
LAWS[control_law_study.ORACLE] = lambda _: STAND_IN
"""Who competes, by the names that the report gives them."""
CLOSE = control_law_study.LAWS[2:]
"""Laws whose steps are kept: open loop and printed gains do not come to the set-point."""
SHOWN = (
    *(
        "residual_rms_n",
        "hold_rms_n",
        "r2_identity",
        *(f"r2_identity_{level:g}_n" for level in trial_protocol.LEVELS_N),
    ),
    *("fall_10_90_s", "rise_10_90_s", "relative_index", "over_oracle"),
)
LENGTHS_UM = trial_protocol.lengths_of(the_bench())
FOLDER = Path(control_law_study.__file__).parent / "stored"


def race(duration_s: float = trial_protocol.DURATION_S) -> tuple[dict[str, Any], xr.Dataset]:
    """Run and score all laws; return what is kept of them, and the steps of the median finger."""
    with deciding():
        whole = rooms.run_laws(the_bench(), LAWS, rooms.SMALL, speeds_mm_s=[SPEED_MM_S], duration_s=duration_s)
        traces = step_traces(whole, SPEED_MM_S)
    every = rooms.scores(whole)
    scored, rows = (
        every.sel(speed_mm_s=SPEED_MM_S),
        rooms.score_rows(every) + over_oracle(every, control_law_study.ORACLE),
    )
    some = scored["capable"].values
    finger = trial_protocol.median_finger(whole.people, some) or {}
    number = next(i for i, each in enumerate(whole.people) if each is finger)
    found: dict[str, Any] = {
        "command": control_law_study.COMMAND,
        "version": package_version(),
        "seed": whole.seed,
        "speed_mm_s": SPEED_MM_S,
        "capable": some.tolist(),
        "limit_n": _limits_n(finger),
        "laws": {},
    }
    for law in whole.laws:
        worst = worst_tick(whole.system.evolve(whole.laws[law]).controller.kind)
        knows = law == control_law_study.ORACLE  # which is no loop, and has no image
        own: dict[str, Any] = {"tick_instructions": None if knows else worst}
        for z in LENGTHS_UM:
            residual = scored["residual_rms_n"].sel(law=law, slip_length_um=z).values
            peaks = (math.nan, math.nan) if knows else _peaks(whole, law, z)
            own[f"{z:g}"] = {
                "scores": {name: _both(rows, law, z, name) for name in SHOWN},
                "sensitivity_peak": _kept(peaks[0]),
                "sensitivity_peak_10": _kept(peaks[1]),
                "median_finger_rms_n": _kept(residual[number]),
                "residual_rms_n": [_kept(each) for each in residual],
            }
        found["laws"][law] = own
    return found, traces


def write(found: Mapping[str, Any], traces: xr.Dataset, folder: Path = FOLDER) -> None:
    """Write both files: numbers as JSON, forces around two steps as CSV."""
    told = re.sub(r"\[[^][]*\]", lambda row: " ".join(row[0].split()), json.dumps(found, indent=1))
    (folder / control_law_study.SUMMARY).write_text(told + "\n", encoding="utf-8")
    columns = [(law, z) for law in CLOSE for z in LENGTHS_UM]
    with (folder / control_law_study.STEPS).open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["time_s", "f_r", *(f"{law}, {z:g}" for law, z in columns)])
        for window in WINDOWS_S:
            part = traces.sel(time=slice(*window))
            forces = [part["f_a"].sel(law=law, slip_length_um=z).values for law, z in columns]
            set_to = part["f_r"].isel(law=0, slip_length_um=0).values
            for row in zip(part["time"].values, set_to, *forces, strict=True):
                writer.writerow([f"{row[0]:.4f}", *(f"{force:.5g}" for force in row[1:])])


def _kept(value: float) -> float | str:
    """Return a number in six digits; JSON has no other way to say inf and nan than in words."""
    return float(f"{value:.6g}") if math.isfinite(value) else str(float(value))


def _both(rows: list[dict[str, Any]], law: str, length_um: float, score: str) -> list[float | str]:
    where = {"law": law, "slip_length_um": length_um, "population": "capable", "score": score}
    return [_kept(rooms.value_of(rows, key, **where)) for key in (control_law_study.MEDIAN, control_law_study.WORST)]


def _limits_n(finger: Mapping[str, Any]) -> dict[str, float | str]:
    stroked = the_bench().evolve({"motion.stroke_mm": trial_protocol.stroke_mm(SPEED_MM_S)})
    found = linear_reach_table(stroked, [finger], [SPEED_MM_S], LENGTHS_UM, peaks=[PEAK])["bound_rms_n"]
    of_both = found.sel(measured="force and load", speed_mm_s=SPEED_MM_S, sensitivity_peak=PEAK, drop=True)
    return {f"{z:g}": _kept(of_both.sel(slip_length_um=z).item()) for z in LENGTHS_UM}


def _peaks(whole: rooms.LawRuns, law: str, length_um: float) -> tuple[float, float]:
    """Return Ms with the resonance as the bench says, and the worst of that and of 10 % off; NaN without a loop."""
    system = law_margins.median_system(whole, law, SPEED_MM_S, length_um)
    if system is None:
        return math.nan, math.nan
    shifted = (on_device(system, factor) for factor in (1.0, 0.9, 1.1))
    loops = [law_margins.loop_at(each, LEVEL_N, whole.middle_s) for each in shifted]
    found = [math.nan if loop is None else loop.margins().sensitivity_peak for loop in loops]
    return found[0], max(found)


if __name__ == "__main__":
    write(*race())
