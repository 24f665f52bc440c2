"""The report's results, computed once for all tests of claims."""

from __future__ import annotations

import pytest

from frictionloop.report.claims import all_claims
from frictionloop.report.results import Results


@pytest.fixture(scope="session")
def results():
    return Results()


@pytest.fixture(scope="session")
def claims(results):
    return all_claims(results)


@pytest.fixture(scope="session")
def by_id(claims):
    return {claim.id: claim for claim in claims}
