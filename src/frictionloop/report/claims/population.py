"""Claims of Sec. 2.1 about fingers, Fig. 1a: what the synthetic trials can say."""

from __future__ import annotations

from frictionloop.physics.trials import mean_law, standard_error
from frictionloop.report.claims.claim import Claim, python
from frictionloop.report.results import Results

TRIALS = "from frictionloop.physics.trials import *; "
UNPUBLISHED = (
    "The recordings are not published, so this says only whether the spread of fingers assumed here agrees with the "
    "printed mean: "
)


def population_claims(results: Results) -> list[Claim]:
    """Return the claims about the mean of the trials."""
    law = mean_law(results.population)
    f0, tau = law.nominal_n, law.susceptibility_per_um2
    return [_f0(f0, standard_error(results.population, "f0")), _tau(tau, standard_error(results.population, "tau"))]


def _f0(fitted: float, error: float) -> Claim:
    return Claim(
        id="population-f0",
        title="Trials average to f₀ = 0.8 N (synthetic)",
        place="Sec. 2.1, Fig. 1a",
        quote="f₀ = 0.8 N is the nominal friction force",
        published=0.8,
        unit="N",
        measure="least-squares fit of equation (1) to the mean of the synthetic trials",
        readings={"synthetic trials": fitted},
        accepted=(0.8 - 2 * error, 0.8 + 2 * error),
        tolerance=f"two standard errors of the mean of the 26 trials ({error:.2g} N)",
        explanation=UNPUBLISHED
        + "f₀ from 0.5 to 1.4 N is centred above 0.8 N. The 0.9 N that the device rendered asks for "
        "such fingers too.",
        command=python(TRIALS + "print(mean_law(sliding_trials()).nominal_n)"),
    )


def _tau(fitted: float, error: float) -> Claim:
    return Claim(
        id="population-tau",
        title="Trials average to τ = 0.38 µm⁻² (synthetic)",
        place="Sec. 2.1, Fig. 1a",
        quote="τ = 0.38 µm⁻² is the susceptibility to ultrasonic levitation",
        published=0.38,
        unit="µm⁻²",
        measure="least-squares fit of equation (1) to the mean of the synthetic trials",
        readings={"synthetic trials": fitted},
        accepted=(0.38 - 2 * error, 0.38 + 2 * error),
        tolerance=f"two standard errors of the mean of the 26 trials ({error:.2g} µm⁻²)",
        explanation=UNPUBLISHED + "τ is spread around the printed value, so it must.",
        command=python(TRIALS + "print(mean_law(sliding_trials()).susceptibility_per_um2)"),
    )
