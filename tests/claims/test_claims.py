"""Claims are data: complete, unique, with verdicts that follow from their numbers."""

from __future__ import annotations

import json
import math
import re
from importlib.resources import files
from pathlib import Path

import pytest

from frictionloop.parameters import paper
from frictionloop.report.claims import (
    COUNTED,
    TOPICS,
    Claim,
    Group,
    Statement,
    Verdict,
    one_claim,
    others,
    statements,
    within,
)
from frictionloop.report.claims.claim import FILLED, Told, having, lacking, texts
from frictionloop.report.control_law_study import COMMAND
from frictionloop.report.number_text import number, shown
from frictionloop.report.page import claims_json
from frictionloop.report.paper_protocol import CLOSED, IDEAL, PRINTED, RETUNED_GAINS, SLOW
from frictionloop.report.reproduction import Reproduction
from frictionloop.report.results import HALF, Results
from frictionloop.report.step_response import PRINTED_MS
from frictionloop.report.system_comparison import (
    FEASIBLE,
    PER_SAMPLE,
    PER_SECOND,
    WORKING,
    compared,
    in_both_units,
    per_sample,
    readings,
)
from frictionloop.report.tolerances import (
    R2_MUCH,
    R2_STEP,
    YARDSTICKS,
    as_measured,
    as_measured_r2,
    as_printed,
    half_decade,
    nearest_125,
)

YES, IF, NO = Verdict.YES, Verdict.YES_IF, Verdict.NO
JUDGED = {
    YES: "low-gain-attenuates higher-gain-amplifies",
    IF: (
        "clean-of-artefacts kp-range-low kp-range-high kp-1-unsatisfactory close-to-possible kp-40-noisy ki-optimum "
        "kp-40-saturated ki-influence noise-saturation noise-subliminal equation-3 pi-reduces-variability "
        "closed-loop-r2 faster-than-open open-loop-r2 open-loop-variation steady-20-mn rise-time fall-time "
        "amplitude-overshoot printed-gains-stable"
    ),
    NO: (
        "one-order-lower one-order-not-linear kp-40-because-of-sensor-noise kp-optimum noise-precision "
        "low-forces-err-most higher-order-cancels stronger-plate-faster"
    ),
}
LEFT_OUT = {
    Group.CONSTRUCTION: (
        "hammer-resonance sensor-floor dynamic-range-measured fluctuations-of-the-finger range-achievable "
        "calibration-r2"
    ),
    Group.ARITHMETIC: "dynamic-range resonance displacement floor-below-1e-4",
    Group.SLIP: "disturbance-amplitude dynamic-range-db displacement-noise control-period closed-loop-time plate-mode",
    Group.QUESTION: "setpoint-reachable measured-resonance calibration-accuracy population-r2",
}
OF_GAINS = ("pi-reduces-variability", "clean-of-artefacts")
STATED = [IF, IF, NO, NO, NO, NO, NO, NO]


def a_claim(readings, accepted, **more):
    words = dict.fromkeys(
        ("id", "title", "place", "quote", "unit", "measure", "quantity", "tolerance", "explanation"), ""
    )
    return Claim(**words, published=1.0, readings=readings, accepted=accepted, note=1, **more)


@pytest.mark.parametrize(
    ("readings", "condition", "verdict"),
    [
        ({"a": 1.0}, None, YES),
        ({"a": 1.0, "b": 2.0}, None, YES),
        ({"a": 1.0, "b": 2.1}, None, NO),
        ({"a": math.nan}, None, NO),
        ({"a": 1.0, "b": 2.1}, "a", IF),
        ({"a": 1.0, "b": 2.1}, "b", NO),
        ({"a, c": 1.0, "b": 2.1, "d, c": 1.5}, "c", IF),
        ({"a, c": 1.0, "b": 2.1, "d, c": None}, "c", NO),
        ({"a": 1.0}, "absent", NO),
    ],
)
def test_the_verdict_follows_from_the_numbers_and_the_named_condition(readings, condition, verdict):
    claim = a_claim(readings, (1.0, 2.0), condition=condition and (condition, "so"))
    assert claim.verdict == verdict and claim.verdict_text == ("yes, if so" if verdict is IF else verdict)


def test_what_the_text_leaves_open_may_be_a_condition_and_what_is_only_compared_may_not():
    b = ("b", "b is so")
    assert a_claim({"a": 3.0}, (1.0, 2.0), assumed={"b": 1.5}, condition=b).verdict == IF
    assert a_claim({"a": 3.0}, (1.0, 2.0), assumed={"b": 1.5}).verdict == NO
    assert a_claim({"a": 1.5}, (1.0, 2.0), assumed={"b": 3.0}).verdict == NO
    assert a_claim({"a": 3.0}, (1.0, 2.0), compared={"b": 1.5}, condition=b).verdict == NO


@pytest.mark.parametrize("group", Group)
def test_what_is_not_the_papers_statement_is_not_counted(group):
    assert a_claim({"a": 1.5}, (1.0, 2.0), group=group).verdict == Verdict.NOT_COUNTED


def test_parts_of_a_statement_have_to_hold_together():
    x, y = a_claim({"a": 1.0, "b": 3.0}, (1.0, 2.0)), a_claim({"a": 3.0, "b": 1.0}, (1.0, 2.0))
    always = a_claim({"c": 1.0}, (1.0, 2.0))
    a = ("a", "so")
    of = [((always,), None), ((x, always), None), ((x, always), a), ((x, y), a)]
    found = [Statement(title="", number="", claims=claims, condition=condition) for claims, condition in of]
    assert [each.verdict_text for each in found] == ["yes", "no", "yes, if so", "no"]


def test_no_part_of_a_name_makes_a_statement_true_that_is_said_to_be_false(claims):
    """Found by trying all: one reading would have to give an accepted number for each of its claims."""
    for statement in statements(claims):
        votes = [{**claim.readings, **claim.assumed} for claim in statement.claims]
        parts = {part for some in votes for name in some for part in (name, *name.split(", "))}
        found = [
            part
            for part in parts
            if all(
                claim.verdict is YES or any(claim.holds[name] for name in having(some, [part]))
                for claim, some in zip(statement.claims, votes, strict=True)
            )
        ]
        assert bool(found) == (statement.verdict is not NO), statement.title


def test_a_condition_is_named_where_one_thing_is_enough(claims):
    """Found by trying all: each part of a name, and the working reading."""
    for claim in claims:
        if claim.group is None:
            votes = {**claim.readings, **claim.assumed}
            every = all(claim.holds[name] for name in votes)
            assert every == (claim.verdict is YES), claim.id
            parts = {part for name in votes for part in name.split(", ")}
            enough = {part for part in (*parts, next(iter(votes))) if claim.holds_under(part)}
            assert bool(enough) == (claim.verdict is not NO), (claim.id, enough)
            assert every or claim.condition is None or claim.condition[0] in enough, (claim.id, enough)


def test_parts_of_names_are_found():
    values = {"a, b": 1.0, "b": 2.0, "ab": 3.0, "c, d": 4.0}
    assert having(values, ["b"]) == {"a, b": 1.0, "b": 2.0}
    assert lacking(values, ["b", "d"]) == {"ab": 3.0}
    assert having({"c, d, e": 1.0, "c, e": 2.0, "cc, d": 3.0}, ["c, d"]) == {"c, d, e": 1.0}


def test_the_device_is_judged_with_gains_that_are_stable_on_the_bench(claims):
    for claim in claims:
        if having(claim.all_values, [PRINTED]):
            voting = {PRINTED} if claim.id in OF_GAINS else set()
            assert bool(having(claim.readings, [PRINTED])) == bool(voting), claim.id
            assert having(claim.readings, [RETUNED_GAINS, *voting]) == claim.readings, claim.id
        assert not having(claim.readings, [FEASIBLE, IDEAL, HALF]) and not having(claim.assumed, [IDEAL]), claim.id
        assert len(claim.readings) + len(claim.assumed) + len(claim.compared) == len(claim.all_values), claim.id


def test_every_judged_claim_has_a_number(claims):
    for claim in claims:
        assert claim.ours is not None or claim.id in ("kp-range-high", "kp-optimum", "ki-optimum"), claim.id


def test_one_sentence_counts_once(claims):
    counted = [claim.quote for claim in claims if claim.group is None]
    assert len(set(counted)) == len(counted)


def test_verdicts(claims):
    judged = {verdict: {claim.id for claim in claims if claim.verdict is verdict} for verdict in JUDGED}
    left_out = {group: {claim.id for claim in claims if claim.group is group} for group in Group}
    assert judged == {verdict: set(ids.split()) for verdict, ids in JUDGED.items()}
    assert left_out == {group: set(ids.split()) for group, ids in LEFT_OUT.items()}
    assert all(bool(claim.meant) == (claim.group is Group.SLIP) for claim in claims)
    assert len(claims) == sum(map(len, [*judged.values(), *left_out.values()])) == len({claim.id for claim in claims})


def test_every_counted_claim_belongs_to_one_statement_or_to_the_others(claims):
    found = [claim.id for claim in [*within(statements(claims)), *others(claims)]]
    assert sorted(found) == sorted(claim.id for claim in claims if claim.group is None)
    assert [each.verdict for each in statements(claims)] == STATED
    for each in statements(claims):
        heads = [
            value for claim in each.claims for value in (claim.ours, *claim.under((claim.condition or "-")[0]).values())
        ]
        shown = {number(value, digits) for value in heads if value is not None for digits in (2, 3, 4)}
        assert shown & set(re.findall(r"[\d.]+", each.number)) and "nan" not in each.number, each.title


def test_claims_of_the_simulation_use_every_reading(claims):
    """But for the two that are about the printed amplitudes themselves."""
    for claim in claims:
        if "simulation" in where(claim) and claim.group is None:
            for names, found in ((readings(), claim.readings), ({FEASIBLE}, claim.assumed)):
                assert not [name for name in names if not having(found, [name])], claim.id


def test_statements_about_gains_are_read_with_ki_per_second_and_per_sample(claims):
    """Every reading and assumption has both, but for statements on noise, whose gains are those of a figure."""
    about = [claim for claim in claims if re.search(r"Kp|Ki|gain", claim.title) and "simulation" in where(claim)]
    assert len(about) > 6
    for claim in about:
        for found in (claim.readings, claim.assumed):
            sampled = {name for name in found if name.endswith(f", {PER_SAMPLE}")}
            others = {name.removesuffix(f", {PER_SECOND}") for name in found if name not in sampled}
            assert {f"{name}, {PER_SAMPLE}" for name in others} == sampled, claim.id


def where(claim):
    """Return the topics that a claim is of."""
    return [topic for topic in TOPICS if claim.id in texts(topic)]


def test_ki_per_sample_adds_the_printed_number_in_each_period():
    system = paper()
    assert per_sample(system).controller.ki == pytest.approx(system.controller.ki / 2e-4)
    assert list(in_both_units({"a": system})) == ["a", f"a, {PER_SAMPLE}"]


def test_both_kinds_of_fit_pooled_and_within_a_level(by_id):
    found = by_id["closed-loop-r2"].all_values
    for name in CLOSED:
        for which in ("pooled", "within one sine"):
            regression, identity = f"{name}, regression, {which}", f"{name}, to f_a = f_r, {which}"
            assert {regression, identity} <= set(found)
            assert found[regression] >= found[identity]


def test_one_yardstick_for_differences_of_fidelity(claims):
    ends = {claim.accepted for claim in claims if claim.measure.startswith(("R²", "change of R²"))}
    assert ends == {(0.0, R2_STEP), (0.0, R2_MUCH)}


def test_arithmetic_needs_no_run_and_is_right_one_way(claims):
    some = [claim for claim in claims if claim.group is Group.ARITHMETIC]
    assert some
    for claim in some:
        results = Results()
        assert one_claim(claim.id, results) == claim
        assert not results.computed(), claim.id
        assert any(claim.holds.values()), f"{claim.id}: wrong in every way, a slip"


def test_the_written_rule_has_the_words_of_verdicts_and_groups():
    rule = (Path(__file__).parents[2] / "docs" / "paper-notes.md").read_text(encoding="utf-8")
    assert [word for word in (*COUNTED, *Group) if f"\n| {word} |" not in rule] == []


def test_a_printed_number_accepts_half_a_unit_of_its_last_digit_that_is_not_zero(claims):
    rounded = [claim for claim in claims if claim.tolerance == YARDSTICKS["rounding"].rule]
    assert rounded and all(claim.accepted == as_printed(claim.published) for claim in rounded)


def test_a_measured_time_agrees_within_the_printed_deviation(by_id):
    for direction, (mean, sd) in PRINTED_MS.items():
        claim = by_id[{"falling": "fall-time", "rising": "rise-time"}[direction]]
        assert claim.published == mean and claim.accepted == (mean - sd, mean + sd)


def test_what_is_measured_has_one_yardstick():
    """A force, an R2 and a bound that somebody measured are no more exact than a factor of two."""
    used = {id: text.get("yardstick") for topic in TOPICS for id, text in texts(topic).items()}
    measured = ("open-loop-r2", "closed-loop-r2", "open-loop-variation", "steady-20-mn")
    assert {used[id] for id in measured} == {"measured R²", "measured force", "at most a measured force"}
    assert set(used.values()) - {None} == set(YARDSTICKS)


def test_a_text_names_a_yardstick_or_says_what_is_accepted():
    for topic in TOPICS:
        for id, text in texts(topic).items():
            assert ("yardstick" in text) != ("accepted" in text), id
            assert "tolerance" in text or "yardstick" in text, id


def test_every_claim_is_complete(claims):
    for claim in claims:
        low, high = claim.accepted
        assert low <= high, claim.id
        for words in (claim.title, claim.quote, claim.measure, claim.tolerance, claim.explanation):
            assert words.strip(), claim.id
        assert not re.search(r"\bnan\b", claim.explanation), claim.id
        assert claim.place.startswith("Sec. "), claim.id
        assert claim.command == f"frictionloop reproduce --only {claim.id}"
        assert claim.seeds == "none" or re.fullmatch(r"\d.*", claim.seeds), claim.id


def test_every_number_that_is_told_is_named_somewhere(claims):
    """In the claim's own texts or, as ``told("id", "name")``, in the page's."""
    templates = files("frictionloop.report") / "templates"
    page = "".join(path.read_text(encoding="utf-8") for path in templates.iterdir())
    for topic in TOPICS:
        for id, text in texts(topic).items():
            own = "".join(text[name] for name in FILLED if name in text)
            for name in next(claim for claim in claims if claim.id == id).told:
                assert f"{{{name}" in own or f'told("{id}", "{name}")' in page, (id, name)


def test_numbers_in_texts_have_the_digits_asked_for():
    assert "{a} {a:2} {b:.0%} {b:.2f}".format(a=Told(0.12345), b=Told(0.5)) == "0.123 0.12 50% 0.50"
    assert "{a, in words:m} {a, in words:2m}".format_map({"a, in words": Told(0.012345)}) == "12.3 12"


def test_a_claim_is_judged_alone_by_what_it_needs(claims):
    results = Results()
    alone = one_claim("kp-range-low", results)
    assert alone == next(claim for claim in claims if claim.id == "kp-range-low")
    assert results.computed() == {"over_kp", "per_sample"}
    assert alone.seeds == "0 to 3"


def test_a_claim_alone_has_all_its_numbers(claims):
    claim = next(claim for claim in claims if claim.id == "equation-3")
    found = Reproduction(folder=Path("report"), page=None, claims=(claim,))
    assert found.table()["accepted"].to_dict() == {
        "at 1 Hz, as printed": False,
        "summed over the noise's spectrum": True,
    }
    assert found.rows()[0][1].startswith("yes, if summed over the spectrum: ") and found.rows()[-1][1].endswith(
        "equation-3 · seeds 0"
    )
    assert found.to_dict()["claims"] == [claim.to_dict()]


def test_claims_of_a_stored_study_name_its_command(claims):
    for claim in claims:
        stored = "stored study" in claim.seeds
        assert stored == (claim.id == "higher-order-cancels")
        assert stored == (COMMAND in claim.measure), claim.id


def test_no_noise_reading_satisfies_both_noise_claims(by_id):
    for reading, subliminal in by_id["noise-subliminal"].holds.items():
        precision = by_id["noise-precision"]
        harmful = [held for name, held in precision.holds.items() if name.startswith(reading)]
        assert not (subliminal and any(harmful)), reading


def both(*names):
    """Return names and what they are with Ki per sample."""
    return {*names, *(f"{name}, {PER_SAMPLE}" for name in names)}


def held_by(claim):
    """Return under what a claim holds, comparisons included."""
    return {name for name, held in claim.holds.items() if held}


def test_what_the_text_says_of_single_readings(claims, results):
    holds = {claim.id: held_by(claim) for claim in claims}
    printed = set(compared()) - {FEASIBLE}
    # "with the amplitudes as printed, however they are read, the useful gains have no upper end"
    ends = {claim.id: claim.readings for claim in claims}["kp-range-high"]
    assert all(ends[name] is None for name in printed) and holds["kp-range-high"] == both(FEASIBLE)
    # "With that set-point the printed level fits a variance or an amplitude density; with the printed ones none"
    assert {name.split(" (")[0] for name in holds["noise-precision"]} == {"variance", "amplitude density"}
    assert all(name.endswith(FEASIBLE) for name in holds["noise-precision"])
    # "Ki changes nothing that counts" with the printed amplitudes
    units = {f"{name}, {unit}" for name in compared() for unit in (PER_SECOND, PER_SAMPLE)}
    assert holds["ki-influence"] == units - {f"{FEASIBLE}, {PER_SAMPLE}"}
    influence = {claim.id: claim.readings for claim in claims}["ki-influence"]
    assert len(influence) == 2 * len(printed) and max(influence.values()) < R2_STEP
    # "where the set-point is largest they leave no room for the difference"
    at_5_khz = {f"{name}, 5 kHz" for name in compared()}
    assert at_5_khz - holds["kp-40-noisy"] == {"zero-to-peak set-point, 5 kHz"}
    # Sampled at 50 kHz the loop is stable at 40, and neither noisy nor saturated by itself
    assert not any("50 kHz" in name for name in holds["kp-40-noisy"])
    assert {f"{FEASIBLE}, 50 kHz", f"{WORKING}, 50 kHz, {PER_SAMPLE}"}.isdisjoint(holds["kp-40-saturated"])
    # "10 and 2 lie well inside the best region", "the optimum is nearer 20 in all"
    fidelity = results.maps[WORKING]["r2_identity"]
    assert float(fidelity.max() - fidelity.sel(kp=10.0, ki=2.0)) < R2_STEP
    best = {claim.id: claim for claim in claims}["kp-optimum"]
    # An optimum of 10 takes Ki per sample or a delay, and a set-point that can be reached
    assert set(best.readings.values()) == {None}
    assert {f"{FEASIBLE}, {HALF}", f"{FEASIBLE}, {PER_SAMPLE}"} <= holds["kp-optimum"]
    assert all(name.endswith((HALF, PER_SAMPLE)) for name in holds["kp-optimum"])
    # 10 is among the best there
    assert best.told["late_low"] < 10 < best.told["late_high"]


def test_claims_json(claims, results):
    text = claims_json(claims, results)
    tree = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert tree["schema"] == 2
    assert set(tree) == {"schema", "version", "systems", "seeds", "statements", "claims"}
    keys = {"id", "title", "place", "quote", "published", "ours", "unit", "measure", "readings", "tolerance", "verdict"}
    keys |= {"compared", "assumed", "quantity", "group", "meant", "note", "seeds"}
    for row in tree["claims"]:
        assert set(row) == keys | {"explanation", "command"}
        assert isinstance(row["published"], (int, float, str))
        assert all(value is None or isinstance(value, (int, float)) for value in row["readings"].values())
        assert set(row["tolerance"]) == {"accepted", "from"}
    by_id = {claim.id: claim.verdict_text for claim in claims}
    assert {row["id"]: row["verdict"] for row in tree["claims"]} == by_id
    assert all(set(row) == {"title", "number", "verdict", "claims"} for row in tree["statements"])


def test_numbers_are_shown_with_the_digits_they_need(by_id):
    assert shown(1.0) == "1" and shown(None) == "none"
    assert shown(1.0026, 4) == "1.003" and shown(0.9998) == "1"
    assert by_id["calibration-r2"].paper_and_ours[1].startswith("1 − ")
    assert by_id["hammer-resonance"].accepts == "144.5 to 145.5 Hz"
    assert by_id["steady-20-mn"].paper_and_ours[0] == "0.02 N"


def test_an_interval_is_shown_wide_enough(claims):
    """No end of an interval is rounded by a tenth of its width or more."""
    for claim in claims:
        low, high = claim.accepted
        if 0 < low < high < math.inf and low >= 1e-3:
            assert max(abs(float(shown(end, claim.digits)) - end) for end in (low, high)) < 0.1 * (high - low), claim.id


def test_the_answer_has_every_statement_within_a_screen_and_counts_every_claim(claims):
    some = tuple(statements(claims))
    found = Reproduction(folder=Path("report"), page=Path("report/index.html"), claims=tuple(claims), statements=some)
    assert list(found.table("claims").index) == [claim.id for claim in claims]
    assert found.table().to_numpy().sum() == len(some) + sum(claim.group is None for claim in claims)
    assert [said.split(": ")[0] for _, said in found.rows()[:-1]] == [each.verdict_text for each in some]
    assert len(str(found).splitlines()) <= 24


def test_tolerances():
    assert nearest_125(10.0) == pytest.approx((math.sqrt(50), math.sqrt(200)))
    assert as_measured(0.25) == (0.125, 0.5)
    for r2 in (0.22, 0.98):
        low, high = as_measured_r2(r2)
        noise, ends = math.sqrt((1 - r2) / r2), [math.sqrt((1 - end) / end) for end in (low, high)]
        assert ends == pytest.approx([2 * noise, noise / 2])
    assert half_decade(1e-4) == pytest.approx((10**-4.5, 10**-3.5))


def test_what_the_text_says_of_the_device(by_id):
    holds = {id: held_by(claim) for id, claim in by_id.items()}
    assert not any(name.startswith(f"{PRINTED}, regression") for name in holds["closed-loop-r2"])
    assert {f"{RETUNED_GAINS}, regression, pooled", f"{IDEAL}, regression, pooled"} <= holds["closed-loop-r2"]
    # On rising steps the command overshoots under every controller but a slow one
    assert {f"{name}, rising" for name in CLOSED if name != SLOW} <= holds["amplitude-overshoot"]
    # "Rising steps wait for the skin": a stronger plate changes nothing for a controller that does not ring
    assert not {f"{RETUNED_GAINS}, rising", f"{IDEAL}, rising"} & holds["stronger-plate-faster"]
    # "the largest stable Kp is" far below the printed gain; only without resonance and delay is it above
    assert holds["printed-gains-stable"] == {"without either", "in mN/N"}
    # A slower integral falls and rises as printed, however it is timed
    for id in ("fall-time", "rise-time"):
        assert having(by_id[id].all_values, [SLOW]).keys() <= holds[id]
    # The printed numbers are those of one slope, and the finger with it has an R2 like the printed one
    told = by_id["open-loop-r2"].told
    assert (told["printed_slope"], told["near_slope"]) == (pytest.approx(0.75, abs=0.01), pytest.approx(0.75, abs=0.05))
    assert told["printed_slope"] == pytest.approx(0.25 * math.sqrt(0.22 / 0.78 / (0.08 / 3 + 0.005)), rel=1e-3)
    # The re-tuned gains add a little, and "so does a loop without resonance and delay"; the printed ones are felt
    assert holds["clean-of-artefacts"] == {RETUNED_GAINS, IDEAL}
