"""Claims are data: complete, unique, with verdicts that follow from their numbers."""

from __future__ import annotations

import contextlib
import io
import json
import math
import subprocess
import sys

import pytest

from frictionloop.report.build import claims_json
from frictionloop.report.claims import Claim, Verdict, claims_table
from frictionloop.report.claims.tolerances import as_printed, half_decade, nearest_125

REPRODUCED, NOT, READING = Verdict.REPRODUCED, Verdict.NOT_REPRODUCED, Verdict.READING_DEPENDENT
VERDICTS = {
    "kp-range-low": READING,
    "kp-range-high": READING,
    "kp-optimum": READING,
    "ki-influence": REPRODUCED,
    "close-to-possible": REPRODUCED,
    "kp-40-saturated": REPRODUCED,
    "kp-40-noisy": REPRODUCED,
    "kp-40-because-of-sensor-noise": NOT,
    "kp-1-unsatisfactory": REPRODUCED,
    "noise-precision": READING,
    "noise-saturation": READING,
    "noise-subliminal": READING,
    "low-gain-attenuates": REPRODUCED,
    "equation-3": READING,
    "one-order-lower": READING,
    "one-order-not-linear": NOT,
    "disturbance-amplitude": READING,
    "setpoint-reachable": NOT,
    "band-low": READING,
    "band-high": NOT,
    "disturbance-rejection": REPRODUCED,
    "dynamic-range": REPRODUCED,
    "dynamic-range-95-db": NOT,
    "dynamic-range-93-db": NOT,
    "resonance": REPRODUCED,
    "measured-resonance": NOT,
    "displacement": REPRODUCED,
    "displacement-noise": NOT,
    "control-period": NOT,
}
"""The page's prose says the same as these; a change here is a change there."""


def a_claim(readings, accepted):
    words = dict.fromkeys(("id", "title", "place", "quote", "unit", "measure", "tolerance", "explanation"), "")
    return Claim(**words, published=1.0, readings=readings, accepted=accepted, command="")


@pytest.mark.parametrize(
    ("readings", "verdict"),
    [
        ({"a": 1.0}, REPRODUCED),
        ({"a": 1.0, "b": 2.0}, REPRODUCED),
        ({"a": 1.0, "b": 2.1}, READING),
        ({"a": None, "b": 2.0}, READING),
        ({"a": None}, NOT),
        ({"a": math.nan, "b": 0.9}, NOT),
    ],
)
def test_the_verdict_follows_from_the_numbers(readings, verdict):
    assert a_claim(readings, (1.0, 2.0)).verdict == verdict


def test_ours_is_the_first_reading():
    assert a_claim({"working": 3.0, "other": 1.0}, (1.0, 2.0)).ours == 3.0


def test_ids_are_unique_and_verdicts_as_the_page_tells(claims):
    assert len({claim.id for claim in claims}) == len(claims)
    assert {claim.id: claim.verdict for claim in claims} == VERDICTS


def test_every_claim_is_complete(claims):
    for claim in claims:
        low, high = claim.accepted
        assert low <= high, claim.id
        for words in (claim.title, claim.quote, claim.measure, claim.tolerance, claim.explanation):
            assert words.strip(), claim.id
        assert "nan" not in claim.explanation, claim.id
        assert claim.place.startswith("Sec. "), claim.id
        assert claim.command.startswith('python -c "') and claim.command.count('"') == 2, claim.id


def test_every_command_prints_the_number(claims):
    for claim in claims:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(claim.command.removeprefix('python -c "').removesuffix('"'), {})
        shown = printed.getvalue().strip()
        if claim.ours is None:
            assert shown == "None", claim.id
        else:
            assert float(shown) == pytest.approx(claim.ours, rel=1e-9), claim.id


@pytest.mark.slow
def test_a_command_runs_in_a_shell(claims):
    claim = next(claim for claim in claims if claim.id == "kp-optimum")
    command = claim.command.replace("python", sys.executable, 1)
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert float(done.stdout) == claim.ours


def test_no_noise_reading_satisfies_both_noise_claims(claims):
    by_id = {claim.id: claim for claim in claims}
    for reading, subliminal in by_id["noise-subliminal"].holds.items():
        harmful = [held for name, held in by_id["noise-precision"].holds.items() if name.startswith(reading)]
        assert not (subliminal and any(harmful)), reading


def test_claims_json(claims, results):
    text = claims_json(claims, results)
    tree = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert tree["schema"] == 1
    assert set(tree) == {"schema", "version", "systems", "seeds", "claims"}
    keys = {"id", "title", "place", "quote", "published", "ours", "unit", "measure", "readings", "tolerance", "verdict"}
    for row in tree["claims"]:
        assert set(row) == keys | {"explanation", "command"}
        assert isinstance(row["published"], (int, float, str))
        assert all(value is None or isinstance(value, (int, float)) for value in row["readings"].values())
        assert set(row["tolerance"]) == {"accepted", "from"}
        assert row["verdict"] in set(Verdict)


def test_the_table_has_a_row_per_claim(claims):
    assert claims_table(claims).row_count == len(claims)


def test_tolerances():
    assert as_printed(250, 10) == (245, 255)
    assert nearest_125(10.0) == pytest.approx((math.sqrt(50), math.sqrt(200)))
    assert half_decade(1e-4) == pytest.approx((10**-4.5, 10**-3.5))
