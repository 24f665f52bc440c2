"""The paper's claims as data, each with a verdict that its numbers decide."""

from __future__ import annotations

from frictionloop.report.claims.amplitude import amplitude_claims
from frictionloop.report.claims.beyond import beyond_claims
from frictionloop.report.claims.characterisation import characterisation_claims
from frictionloop.report.claims.claim import Claim, Verdict
from frictionloop.report.claims.closed_loop import closed_loop_claims
from frictionloop.report.claims.equation3 import equation_3_claims
from frictionloop.report.claims.errors import error_claims
from frictionloop.report.claims.gains import gain_claims
from frictionloop.report.claims.model import model_claims
from frictionloop.report.claims.noise import noise_claims
from frictionloop.report.claims.people import people_claims
from frictionloop.report.claims.plate import device_claims
from frictionloop.report.claims.sensor import sensor_claims
from frictionloop.report.claims.steps import step_claims
from frictionloop.report.claims.table import claims_table
from frictionloop.report.claims.tracking import tracking_claims
from frictionloop.report.results import Results

__all__ = ["Claim", "Verdict", "all_claims", "claims_table"]


def all_claims(results: Results) -> list[Claim]:
    """Return every claim in the order of the paper's topics."""
    return [
        *gain_claims(results),
        *tracking_claims(results),
        *noise_claims(results),
        *equation_3_claims(results),
        *model_claims(results),
        *sensor_claims(),
        *characterisation_claims(results),
        *device_claims(),
        *closed_loop_claims(results),
        *error_claims(results),
        *step_claims(results),
        *amplitude_claims(results),
        *people_claims(results),
        *beyond_claims(results.beyond),
    ]
