"""The calibration wizard: by itself at a simulated device, step by step at another, and what it refuses."""

from __future__ import annotations

import os
import select
import threading
import tty
from types import SimpleNamespace

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.device.transport import opener
from frictionloop.identification.calibration_wizard import LASTS_S, RIG_HZ


def run(capsys, *words):
    with pytest.raises(SystemExit) as left:
        main(["identify", "run", *map(str, words)])
    return left.value.code, *capsys.readouterr()


def entry(shown):
    """Return the lines of a project file from the screen."""
    lines = [line.removeprefix("project").strip() for line in shown.splitlines()]
    return "\n".join(line for line in lines if line.startswith(("[[", "kind", "files", "map"))) + "\n"


@pytest.mark.slow
def test_slides_of_the_simulated_device_give_its_friction(tmp_path, capsys):
    out = tmp_path / "friction.h5"
    code, shown, said = run(capsys, "friction", "--device", "sim:", "--out", out)
    assert code == 0 and " 0 lost" in shown and "slide both ways" in said
    (tmp_path / "lab.toml").write_text(entry(shown))
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
        projects.append(entry(shown))
    (tmp_path / "lab.toml").write_text("".join(projects))
    found = fl.identify.bench(tmp_path / "lab.toml")
    assert found.system.sensor.resonance_hz == pytest.approx(145.0, rel=1e-3)
    sensitivity = found.measured["sensitivity"]
    assert sensitivity.unit == "counts/N" and sensitivity.value == pytest.approx(2**16 / 5, rel=0.03)
    board = found.system.board
    assert board.force_n_per_count == pytest.approx(5 / 2**16, rel=0.03) and abs(board.force_zero_counts[0]) < 200
    # In newtons through the weights, though the quiet recording is in counts.
    newtons = fl.identify.load(tmp_path / "quiet.h5", {"f_m": {"column": "f_m", "unit": "N"}})
    density = fl.identify.noise(newtons, resonance_hz=145.0).density.value
    assert found.system.sensor.noise_density_n_rthz == pytest.approx(density, rel=0.03)


class Board:
    """A device that loses samples, as a cable does."""

    address = "serial://none"
    info, sample_hz = SimpleNamespace(tick_hz=RIG_HZ), RIG_HZ

    @property
    def parameters(self):
        return {"force.axes": 2}

    def stream(self, duration_s, decimation):
        rows = np.arange(int(duration_s * RIG_HZ), dtype=float)
        yield {"tick": np.delete(rows, [100, 101]), "f_m": np.ones(rows.size - 2)}


def test_each_step_is_asked_for_and_what_is_lost_is_counted():
    asked = []
    found = fl.identify.run("weights", Board(), (0.0, 50.0, 0.0), ask=asked.append)
    assert [step.mass_kg for step in asked] == [0.0, 0.05, 0.0]
    assert set(found.columns["mass"]) == {0.0, 0.05}
    (gaps,) = found.findings
    assert found.lost_samples == gaps.value == 6 and gaps.code == "DATA-GAPS"
    assert found.recording().f_m.sizes["time"] == found.samples


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("weights", "--masses-g", "1,2,x"), "numbers in g"),
        (("weights", "--masses-g", "5,5,5"), "3 or more, different"),
        (("quiet", "--out", "a.csv"), ".h5"),
        (("sleep",), "weights"),
    ],
)
def test_what_is_refused_is_one_line(tmp_path, monkeypatch, capsys, words, says):
    monkeypatch.chdir(tmp_path)
    code, _, said = run(capsys, *words, "--device", "sim:")
    assert code == 2 and says in said


class Served:
    """The simulated device behind a serial port: what its host sends and hears goes through a pseudo-terminal."""

    def __init__(self, system):
        self._pipe = opener("sim:", system)()
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        self.address, self._on = f"serial://{os.ttyname(self._theirs)}", True
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self):
        while self._on:
            if select.select([self._ours], [], [], 0.001)[0]:
                self._pipe.write(os.read(self._ours, 4096))
            if said := self._pipe.read(0.01):
                os.write(self._ours, said)

    def stop(self):
        self._on = False
        self._thread.join()
        self._pipe.close()
        os.close(self._ours)
        os.close(self._theirs)


@pytest.mark.slow
def test_silence_through_a_serial_port_is_in_counts_of_the_board(tmp_path, capsys, monkeypatch):
    system = fl.bench().evolve({"board.force_n_per_count": 1e-4, "board.force_zero_counts": (321, 0)})
    monkeypatch.setattr("builtins.input", lambda text: "")
    monkeypatch.setitem(LASTS_S, "quiet", 1.5)
    served = Served(system)
    try:
        code, shown, _ = run(capsys, "quiet", "--device", served.address, "--out", tmp_path / "quiet.h5")
    finally:
        served.stop()
    assert code == 0 and "quiet.h5" in shown
    file = fl.identify.load(tmp_path / "quiet.h5")
    np.testing.assert_allclose(file.counts, np.rint(file.f_m / 1e-4) + 321, atol=1)
    said = fl.identify.read_map(tmp_path / "quiet-map.toml").channels["f_m"]
    assert said.column == "counts" and said.newtons_per_unit == pytest.approx(1e-4, rel=1e-4)
