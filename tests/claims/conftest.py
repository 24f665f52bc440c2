"""The report's results, computed once for all tests of claims."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest

from frictionloop.design import tournament
from frictionloop.report import beyond
from frictionloop.report.claims import all_claims
from frictionloop.report.results import compute

BEYOND_S = 4.0
"""Duration of the runs of laws beyond the paper here: three periods of the sine count instead of ten."""


@pytest.fixture(scope="session")
def results():
    """All but the laws beyond the paper as in the report: these run for a third of the time (`whole_claims` has it)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tournament, "compare", partial(tournament.compare, duration_s=BEYOND_S))
        return compute()


@pytest.fixture(scope="session")
def claims(results):
    return all_claims(results)


@pytest.fixture(scope="session")
def whole_claims(results):
    """Claims with every law over the whole protocol, for tests that are slow."""
    return all_claims(replace(results, beyond=beyond.race()))
