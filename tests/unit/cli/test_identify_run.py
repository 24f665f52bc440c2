"""The calibration wizard: by itself at a simulated device, step by step at another, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import identify_run, main
from frictionloop.cli.wizard import TICK_HZ, steps_of


def run(capsys, *words):
    with pytest.raises(SystemExit) as left:
        main(["identify", "run", *map(str, words)])
    return left.value.code, *capsys.readouterr()


def test_slides_of_the_simulated_device_give_its_friction(tmp_path, capsys):
    out = tmp_path / "friction.h5"
    code, shown, said = run(capsys, "friction", "--device", "sim:", "--out", out)
    assert code == 0 and "nothing was lost" in shown and "Slide a finger" in said
    project = "\n".join(line for line in shown.splitlines() if line.startswith(("[[", "kind", "files", "map")))
    (tmp_path / "lab.toml").write_text(project + "\n")
    found = fl.identify.bench(tmp_path / "lab.toml")
    assert 0.3 < found.measured["friction.nominal_n"].value < 2.0
    code, _, said = run(capsys, "friction", "--device", "sim:", "--out", out)
    assert code == 2 and "friction.h5" in said and said.count("\n") == 1


@pytest.mark.slow
def test_weights_hits_and_silence_give_the_bench_of_the_rigs(tmp_path, capsys):
    projects = []
    for kind in ("weights", "hits", "quiet"):
        code, shown, _ = run(capsys, kind, "--device", "sim:", "--out", tmp_path / f"{kind}.h5")
        assert code == 0
        projects += [line for line in shown.splitlines() if line.startswith(("[[", "kind", "files", "map"))]
    (tmp_path / "lab.toml").write_text("\n".join(projects) + "\n")
    found = fl.identify.bench(tmp_path / "lab.toml")
    assert found.system.sensor.resonance_hz == pytest.approx(145.0, rel=1e-3)
    assert found.measured["sensitivity"].value == pytest.approx(1.0, rel=0.03)


class Board:
    """A line that loses samples, as a cable does."""

    def stream(self, duration_s, decimation):
        rows = np.arange(int(duration_s * TICK_HZ), dtype=float)
        yield {"tick": np.delete(rows, [100, 101]), "f_m": np.ones(rows.size - 2)}


def test_each_step_is_asked_for_and_what_is_lost_is_counted(monkeypatch, capsys):
    asked = []
    monkeypatch.setattr("builtins.input", lambda text: asked.append(text) or "")
    steps = steps_of("weights", (0.0, 50.0, 0.0))
    columns = identify_run._recorded("weights", steps, Board(), asked=True)
    assert len(asked) == 3 and "step 2 of 3: Hang 50 g" in capsys.readouterr().err
    assert set(columns["mass"]) == {0.0, 0.05}
    assert identify_run._lost(columns["time"]) == 6


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("weights", "--masses-g", "1,2,x"), "must be numbers in g"),
        (("weights", "--masses-g", "5,5,5"), "not all alike"),
        (("quiet", "--out", "a.csv"), ".h5"),
        (("sleep",), "weights"),
    ],
)
def test_what_is_refused_is_one_line(tmp_path, monkeypatch, capsys, words, says):
    monkeypatch.chdir(tmp_path)
    code, _, said = run(capsys, *words, "--device", "sim:")
    assert code == 2 and says in said
