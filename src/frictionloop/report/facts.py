"""The numbers that the page's text quotes, computed like everything else."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictionloop.report import gains
from frictionloop.report.beyond_table import beyond_facts
from frictionloop.report.claims import Claim
from frictionloop.report.counts import HOLDS, THESIS, counts
from frictionloop.report.device_facts import device_facts
from frictionloop.report.figures.fidelity import at_paper
from frictionloop.report.noise import NOISE_READINGS, knee_n
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.systems import FEASIBLE, WORKING, reachable_share


def facts(results: Results, claims: Sequence[Claim]) -> dict[str, str]:
    """Return formatted numbers by name."""
    named = {claim.id: claim for claim in claims}
    limit = named["printed-gains-stable"].ours
    device = device_facts(results) | {"bench kp limit": number(limit or math.nan, 2)}
    answer = {
        "thesis": HOLDS[named[THESIS].verdict],
        "counted": str(counts(claims)["counted"]),
        "optimum under": " or ".join(named["kp-optimum"].under) or "nothing assumed here",
    }
    return (
        _gains(results)
        | _noise(results)
        | device
        | beyond_facts(results.beyond)
        | answer
        | {f"holds {claim.id}": holding(claim) for claim in claims}
    )


def holding(claim: Claim) -> str:
    """Return for which readings a claim holds, in words that follow "holds"."""
    yes = [name for name in claim.readings if claim.holds[name]]
    no = [name for name in claim.readings if not claim.holds[name]]
    beside = [name for name in claim.assumed if claim.holds[name]]
    if not no:
        return "under every reading"
    if not yes:
        return "under no reading" + (f", only for {', '.join(f'“{name}”' for name in beside)}" if beside else "")
    names = yes if len(yes) <= len(no) else no
    quoted = ", ".join(f"“{name}”" for name in names)
    return f"only for {quoted}" if names is yes else f"except for {quoted}"


def _gains(results: Results) -> dict[str, str]:
    found: dict[str, str] = {}
    for short, name in (("printed", WORKING), ("reachable", FEASIBLE)):
        cut, fidelity = results.over_kp[name], results.maps[name]
        best = gains.optimum(fidelity["r2_identity"])
        useful = gains.useful_range(cut["r2_identity"])
        found |= {
            f"{short} r2": f"{at_paper(fidelity['r2_identity']):.3f}",
            f"{short} bound": f"{float(cut['r2_bound']):.3f}",
            f"{short} map best": f"{best.r2:.3f}",
            f"{short} map kp": number(best.kp),
            f"{short} map ki": number(best.ki, 2),
            f"{short} cut kp": number(gains.optimum(cut["r2_identity"]).kp),
            f"{short} useful low": number(useful.low or math.nan),
            f"{short} useful high": "none" if useful.high is None else number(useful.high),
            f"{short} saturated 40": f"{gains.at(cut['saturation_index'], 40.0):.0%}",
            f"{short} saturated 10": f"{gains.at(cut['saturation_index'], 10.0):.0%}",
            f"{short} r2 1": f"{gains.at(cut['r2_identity'], 1.0):.2f}",
        }
    delays = {"half": "half a period of delay", "whole": "one period of delay"}
    found |= {k: number(gains.optimum(results.variants[name]["r2_identity"]).kp) for k, name in delays.items()}
    shares = {name: reachable_share(system) for name, system in results.systems.items()}
    found |= {f"share {name}": f"{share:.0%}" for name, share in shares.items()}
    found |= {f"bound {name}": number(float(cut["r2_bound"]), 2) for name, cut in results.over_kp.items()}
    over_ki = results.over_ki[FEASIBLE]["r2_identity"]
    found |= {f"r2 at ki 1e{power}": number(gains.at(over_ki, 10.0**power), 3) for power in (4, 5)}
    return found


def _noise(results: Results) -> dict[str, str]:
    steady = results.steady
    knees = {
        f"{short} {metric}": knee_n(results.noise[name][metric])
        for short, name in (("printed", WORKING), ("reachable", FEASIBLE))
        for metric in ("r2_identity", "saturation_index")
    }
    found = {f"knee {name} mN": "none" if sigma is None else number(1e3 * sigma) for name, sigma in knees.items()}
    for output in ("f", "u"):
        found[f"gain {output} 10"] = f"{float(steady[f'simulated_{output}'].sel(kp_simulated=10.0)):.2f}"
    for name in ("amplitude density", "power density", "variance"):
        found[f"sigma {name} N"] = number(NOISE_READINGS[name].sigma_n(1e-5), 2)
    found["gain f 1"] = f"{float(steady['simulated_f'].sel(kp_simulated=1.0)):.2f}"
    found["kp limit"] = f"{float(steady['kp_limit']):.1f}"
    found["cycle 20 mN"] = number(1e3 * 1e-5 * float(steady["simulated_f"].sel(kp_simulated=20.0)), 2)
    return found
