"""A project of plate, delay, touch and fingers: values in their intervals, certificate, population, comparison."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import simulated_plate_lab as simulated

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.identification import compare


def run(capsys, *words):
    with pytest.raises(SystemExit) as left:
        main(["identify", *map(str, words)])
    return left.value.code, *capsys.readouterr()


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return simulated.lab(tmp_path_factory.mktemp("plate"), seed=3)


@pytest.fixture(scope="module")
def found(lab):
    """Also keeps the results beside the projects, so that the commands analyse nothing twice."""
    measured = fl.identify.bench(lab)
    for name in ("lab", "other", "few"):
        results = json.dumps(measured.entry_results())
        (lab.parent / f"{name}.results.json").write_text(results)
    return measured


@pytest.mark.slow
def test_values_are_in_their_intervals(found):
    for name, true in simulated.TRUTH.items():
        low, high = found.measured[name].interval(0.999)
        assert low < true < high, name
    system = found.system
    assert system.plate.q == pytest.approx(180, rel=0.01) and system.plate.frequency_hz == pytest.approx(41e3, rel=1e-4)
    assert system.controller.model.max_amplitude_um == system.plate.max_amplitude_um
    assert system.controller.model.susceptibility_per_um2 == system.friction.susceptibility_per_um2
    assert system.board.load_n_per_count == pytest.approx(1 / 5000, rel=1e-3)
    assert system.board.load_zero_counts in range(297, 304)
    assert system.board.position_m_per_count == pytest.approx(2e-6, rel=1e-3)


def test_fingers_make_a_population(found):
    medians = {each.path: each.median for each in found.people.population.value}
    f0, tau = (np.exp(np.mean(np.log(each))) for each in zip(*simulated.FINGERS.values(), strict=True))
    assert medians["friction.nominal_n"] == pytest.approx(f0, rel=0.05)
    assert medians["friction.susceptibility_per_um2"] == pytest.approx(tau, rel=0.05)
    for name, raw in zip(found.people.names, np.exp(found.people.raw), strict=True):
        assert raw == pytest.approx(simulated.FINGERS[name], rel=0.1)
    assert not any(each.code == "METHODS-DIFFER" and each.severity == "warning" for each in found.findings)


@pytest.mark.slow
def test_gains_at_all_corners_hold_on_the_true_bench(found):
    """Round trip: the bench as measured, its corners, retune, and the bench that made the recordings."""
    assert {each.path for each in found.corners} >= {"plate.q", "controller.delay_s", "friction.nominal_n"}
    loops = [
        loop
        for corner in found.corners
        if corner.path in ("plate.q", "controller.delay_s", "friction.susceptibility_per_um2")
        for loop in fl.operating_band(found.system.evolve({corner.path: corner.value}))
    ]
    tuned = fl.retune(loops)
    true = found.system.evolve(
        {"plate.frequency_hz": 41e3, "plate.q": 180.0, "plate.max_amplitude_um": 2.2, "controller.delay_s": 230e-6}
    )
    for f0, tau in simulated.FINGERS.values():
        finger = {"friction.nominal_n": f0, "friction.susceptibility_per_um2": tau}
        for loop in fl.operating_band(true.evolve(finger | tuned.overrides)):
            assert loop.margins().stable and loop.margins().sensitivity_peak < 2.0


@pytest.mark.slow
def test_command_certificate_and_comparison(lab, found, tmp_path, capsys):
    page, people, out = tmp_path / "c.html", tmp_path / "people.toml", tmp_path / "b.toml"
    code, shown, _ = run(capsys, "bench", lab, "--report", page, "--population", people, "--out", out)
    assert code == 0 and re.search(r"^fingers +3: ", shown, re.MULTILINE)
    html = page.read_text()
    assert html.count("<svg") == 1 + 8 + 3 and "Corners" in html
    rows = re.findall(r"<tr><td><code>sensor.resonance_hz</code></td>(.*?)</tr>", html)
    low, high = (float(each) for each in re.findall(r"<td>([\d.]+) mN</td>", rows[0]))
    # The bench with a lower resonance leaves more, and both are tens of millinewtons (docs/will-it-ring).
    assert 5 < high < low < 200
    assert len(fl.fingers(4, 0, population=people)) == 4
    assert "measured" in next(line for line in out.read_text().splitlines() if line.startswith("delay_s"))
    values = compare(page, page).values
    assert values and not any(each.changed for each in values)
    code, shown, _ = run(capsys, "bench", lab, "--json")
    (tmp_path / "older.json").write_text(shown)
    tree = json.loads(shown)
    assert {each["path"] for each in tree["corners"]} >= {"plate.q"} and tree["people"]["population"]["fingers"] == 3
    hertz = next(each for each in tree["measured"] if each["path"] == "plate.frequency_hz")
    hertz["value"] -= 500
    tree["measured"] = [each for each in tree["measured"] if each["path"] != "crosstalk"]
    (tmp_path / "older.json").write_text(json.dumps(tree))
    code, shown, _ = run(capsys, "compare", tmp_path / "older.json", page)
    assert (
        code == 0
        and "VALUE-CHANGED  plate.frequency_hz" in shown
        and re.search(r"^crosstalk .* - ", shown, re.MULTILINE)
    )
    code, shown, _ = run(capsys, "compare", tmp_path / "older.json", page, "--json")
    changed = [each["path"] for each in json.loads(shown)["values"] if each["changed"]]
    assert changed == ["plate.frequency_hz"]


def test_what_the_commands_refuse(lab, found, tmp_path, capsys):
    (tmp_path / "page.html").write_text("<p>no certificate</p>")
    code, _, said = run(capsys, "compare", tmp_path / "page.html", tmp_path / "page.html")
    assert code == 2 and "no measured values" in said and said.count("\n") == 1
    text = lab.read_text().replace("control_hz = 5000\n", "").replace(' finger = "ann"', "")
    (lab.parent / "other.toml").write_text(text)
    code, _, said = run(capsys, "bench", lab.parent / "other.toml")
    assert code == 2 and "control_hz is missing: the control rate, in Hz" in said and "jumps.npz" in said
    few = lab.read_text().replace('finger = "ann"', 'finger = "bob"')
    (lab.parent / "few.toml").write_text(few)
    code, _, said = run(capsys, "bench", lab.parent / "few.toml", "--population", tmp_path / "p.toml")
    assert code == 2 and "slides of 3 fingers" in said and not (tmp_path / "p.toml").exists()


def test_a_change_by_welch():
    from scipy.stats import ttest_ind_from_stats

    from frictionloop.identification.certificate_comparison import _change

    def value(mean, error, freedom):
        return fl.identify.Estimate(mean, error, "N", freedom), ""

    told = ttest_ind_from_stats(1.0, 0.3 * 5**0.5, 5, 1.9, 0.2 * 9**0.5, 9, equal_var=False)
    assert _change("a", value(1.0, 0.3, 4), value(1.9, 0.2, 8)).chance == pytest.approx(told.pvalue)
