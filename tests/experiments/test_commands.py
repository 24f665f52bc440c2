"""``frictionloop experiment`` as it is typed: what it says of a session, and what it refuses before it simulates."""

from pathlib import Path

from frictionloop.cli.experiment import _range
from frictionloop.experiments.protocol import read_protocol
from frictionloop.experiments.study_run import unfitted
from frictionloop.experiments.study_summary import fits
from frictionloop.experiments.trial_records import COLUMNS


def test_a_range_has_its_ends_and_its_step():
    assert _range("trials", "20:60:20", 5) == [20, 40, 60]
    assert _range("participants", "6:8", 2) == [6, 7, 8]


def test_a_participant_without_a_threshold_is_told_with_the_reason():
    import pandas

    plan = read_protocol("jnd-friction-staircase")
    row = dict.fromkeys(COLUMNS, 0) | {"participant": "P01", "condition": "closed", "counted": 1, "result": 1.0}
    trials = pandas.DataFrame([row | {"requested": 0.01 * k, "delivered": 0.01 * k} for k in range(3)])
    (found,) = unfitted(fits(plan, trials), "threshold")
    assert (found.code, found.value, found.more["measure"]) == ("STUDY-UNFITTED", 1, "threshold")


def test_the_protocol_of_the_page_passes_its_check(tmp_path):
    """The one that docs/experiments.md shows."""
    from frictionloop.experiments.planning import check
    from frictionloop.experiments.study_run import study_system

    page = (Path(__file__).parents[2] / "docs" / "experiments.md").read_text(encoding="utf-8")
    own = tmp_path / "own.toml"
    own.write_text(page.partition("```toml\n")[2].partition("```")[0], encoding="utf-8")
    found = check(read_protocol(own), study_system())
    assert found.needed.low_n < 0.45 < found.needed.high_n
    assert found.trials[0] >= 80
