"""Every code of the catalogue is raised by a public call, and a finding stands in every form of its answer."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

import joblib
import numpy as np
import pandas
import pytest
import simulated_lab
import xarray as xr
from own_laws import Integral, IntegralGains, State, register_both
from PIL import Image

import frictionloop as fl
from frictionloop.cli.flags import system_given
from frictionloop.cli.studio import _given as on_page
from frictionloop.design import limiting_parts
from frictionloop.design.comparison import law_comparison
from frictionloop.device.errors import FAULTS, fault_code
from frictionloop.experiments.study_run import outside
from frictionloop.findings import CATALOGUE, Result
from frictionloop.findings.render import lines
from frictionloop.firmware import image
from frictionloop.identification import rigs
from frictionloop.loop.growing_file import Column, Spool
from frictionloop.loop.registered_blocks import forget
from frictionloop.studio.offline_choices import Choices, PageBench, axes_of

D, R, X, I = fl.design, fl.rendering, fl.experiments, fl.identify
BENCH, PEOPLE = fl.bench(), fl.fingers(6, 0)
AT_S = np.arange(2000) / 1000.0
LEVEL = {"setpoint": fl.Constant(offset_n=0.6)}
ONE, GAINS = D.Requirements(slip_lengths_um=(11.5,)), {"controller.kind": "pi", "controller.kp": 0.03}
CALLS: dict[str, tuple[Callable[..., Iterator[Any]], tuple[str, ...]]] = {}


class Ramp(fl.Signal):
    """A force from outside, of which no level is known."""

    kind: Literal["ramp"] = "ramp"

    def force_n(self, time_s):
        return 0.5 + 0.01 * time_s


def raises(*codes: str) -> Callable[..., Any]:
    """Keep a function that yields answers, findings and errors, and the codes that it is there for."""

    def kept(call: Callable[..., Iterator[Any]]) -> Callable[..., Iterator[Any]]:
        CALLS[call.__name__] = call, codes
        return call

    return kept


def refused(call: Callable[..., Any], *values: Any, **more: Any) -> fl.FrictionloopError:
    with pytest.raises(fl.FrictionloopError) as error:
        call(*values, **more)
    return error.value


def recorded(name: str, values: Any, head: str = "time_s,Ft [N]", **more: Any) -> fl.Recording:
    np.savetxt(name, np.c_[np.arange(len(values)) / 1000.0, values], header=head, comments="", delimiter=",")
    return fl.Recording(path=name, column=head.partition(",")[2].partition(" ")[0], **more)


def diagnosed(system: fl.System, duration_s: float, **more: Any) -> Result:
    return fl.diagnose(fl.simulate(system, duration_s), **more)


@cache
def boards() -> Any:
    """Return a board made of Python and its line, which tests/protocol has."""
    found = importlib.util.spec_from_file_location("python_board", Path(__file__).parents[1] / "protocol/board.py")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def connected(board: Any = None) -> fl.Device:
    there = boards().Board() if board is None else board
    return fl.Device(lambda: boards().Line(there))


@raises("BAD-VALUE", "UNKNOWN-NAME", "OUT-OF-REACH", "NO-GAINS", "TWO-SYSTEMS", "NO-CONTROLLER")
def bad_input():
    yield refused(BENCH.evolve, {"controller.rate_hz": -1.0})
    yield refused(D.plate().table, "none")
    yield refused(D.check, BENCH.evolve({"setpoint.offset_n": 2.0}))
    yield refused(fl.retune, BENCH, 1.001, 1e4)
    yield refused(system_given, Path("a.toml"), "bench", ())
    yield refused(D.controller, BENCH.evolve(LEVEL), "pi", D.Requirements(1.001, slip_lengths_um=(11.5,)))


@raises("LOOP-UNSTABLE", "PEOPLE-NONE", "PEOPLE-RING", "LOAD-ONE", "FORCE-REACH",
        "SENSOR-RANGE", "BELIEF-FRICTION", "NOISE-COMMAND", "ASSUMED", "RECORDED-LEVEL")  # fmt: skip
def checks():
    slide = {"setpoint": recorded("w.csv", 0.9 + 0.4 * np.sin(AT_S * 9)), "motion.load_n": 0.9, "sensor.range_n": 1.4}
    odd = slide | {"sensor.noise_density_n_rthz": 1e-2, "plate.max_amplitude_um": 1.5, "motion.stroke_mm": 20.0}
    yield D.check(BENCH.evolve(GAINS | {"controller.ki": 60.0} | odd), ONE)


@raises("FINGER-DRY", "NO-LOOP")
def check_of_no_loop():
    dry = {"friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0, "finger": {"kind": "rigid"}}
    yield D.check(BENCH.evolve({"controller.kind": "lookup"} | dry | LEVEL))


@raises("PEOPLE-HOLD", "PEOPLE-WORST", "PEOPLE-GAIN", "PEOPLE-REACH", "PEOPLE-UNSEEN", "PEOPLE-UNLIKE", "MS-BEYOND",
        "RING-MOIST")  # fmt: skip
def check_on_people():
    light, weak = PEOPLE[1] | {"motion.load_n": 0.001}, PEOPLE[2] | {"friction.nominal_n": 0.1}
    strong = {f"{block}.susceptibility_per_um2": 1.6 for block in ("friction", "controller.model")}
    yield D.check(BENCH.evolve(GAINS | {"controller.ki": 20.0} | strong), ONE, [PEOPLE[5], light, weak, PEOPLE[0]])


@raises("LAW-CONTRADICTS", "LOOP-WORSE")
def law_of_ones_own():
    register_both()
    try:
        own = BENCH.evolve({"controller.kind": "dead_band_pi", **LEVEL})
        yield D.check(own, ONE)
        yield fl.diagnose(fl.simulate(own, 2.0))
    finally:
        forget()


@fl.step
def halving(state, measured, setpoint_n, gains, dt):
    u = setpoint_n
    while u > gains.high:
        u = u / 2.0
    return state, fl.ForceCommand(u, 0.0)


@raises("NO-C")
def law_without_c():
    fl.register(fl.Law("integral", halving, State, IntegralGains), Integral)
    try:
        with pytest.raises(fl.FrictionloopError) as refused:
            fl.firmware.law(BENCH.evolve({"controller.kind": "integral"}), "law.c")
        yield refused.value
    finally:
        forget()


@raises("ONE-LENGTH")
def design_at_one_length():
    yield D.controller(BENCH.evolve(LEVEL), "pi", D.Requirements(1.05))


@raises("FORWARD-CLIPPED", "FORWARD-DELAY", "MODEL-SET", "GAIN-BOUND", "NO-SPECTRUM", "ORDER-REDUCED")
def designs():
    exact, rigid = D.Requirements(2.5, resonance_error=0.0), BENCH.evolve(LEVEL | {"finger": {"kind": "rigid"}})
    high = {"setpoint": fl.Constant(offset_n=0.8), "controller.model.resonance_hz": 120.0, "sensor": BENCH.sensor}
    yield D.controller(fl.feasible().evolve(high), "notch_pi", exact)
    yield D.controller(rigid.evolve({"controller.delay_s": 0.0045}), "notch_pi", exact)
    yield D.controller(rigid, "hinf", exact)


@raises("LOWERED", "NOT-LOWERED", "PART-FAILED")
def designs_for_people(monkeypatch):
    must = D.Requirements(slip_lengths_um=(11.5,), finger_gain=1.0)
    strong = PEOPLE[0] | {"friction.susceptibility_per_um2": 60.0}
    yield D.controller(BENCH.evolve(LEVEL), "pi", must, [PEOPLE[5]])
    yield D.controller(BENCH.evolve(LEVEL), "pi", must, [strong])
    found = limiting_parts.synthesised

    def synthesised(system, *of):
        if system.plate.cutoff_hz > 400.0:
            raise fl.FrictionloopError("no controller", "NO-CONTROLLER")
        return found(system, *of)

    monkeypatch.setattr(limiting_parts, "synthesised", synthesised)
    with joblib.parallel_config(backend="sequential"):
        limits = D.limits(fl.feasible(), "pi")
    assert [each.name for each in limits.limiting] == ["rate of 10 kHz"]
    yield limits


@raises("STUDIO-NO-SUM")
def choices_that_depend_on_one_another():
    soft = {"soft": {"finger.damping_n_s_m": 3.0}}
    with pytest.raises(fl.FrictionloopError) as refused:
        axes_of(PageBench(BENCH, 0), Choices({"own": {}}, {"own": {}}, soft, {"finger.stiffness_n_m": [500.0]}, {}))
    yield refused.value


@raises("SPEC-CHANGED", "BELIEF-DIFFERS", "KIND-DEFAULTS", "UNIT-DOUBT", "STUDIO-EFFECT")
def files():
    found = D.check(fl.feasible())
    D.write_controller(found, "c.toml", set())
    yield fl.described("c.toml", overrides={"controller.kp": 1.0}).findings
    changes = {"plate.max_amplitude_um": 1.0, "setpoint.kind": "sine", "setpoint.offset_n": 0.6, "plate.q": 1e6}
    yield fl.described(None, "bench", changes).findings
    yield fl.described(None, "feasible", {"setpoint.kind": "sine", "setpoint.offset_n": 0.6}).findings
    yield D.plate(overrides={"geometry.thickness_mm": 0.003})
    Path("b.toml").write_text('preset = "bench"\n')
    yield on_page(Path("b.toml"), None, None, None).findings


@raises("LOOP-NEAR", "RING-CLAMP", "DISTURBANCE-WIDE", "SETPOINT-REACH", "BOARD-CEILING", "PLACE-ONE",
        "PLACE-UNSEEN", "RANGE-EXCEEDED", "TURNS-IN-CONTACT", "NO-FEEDBACK")  # fmt: skip
def runs():
    small = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Sine(amplitude_n=0.02)}
    yield diagnosed(fl.paper().evolve(small | {"controller.kp": 20.0}), 1.0)
    pulses_n = np.where(AT_S % 0.5 < 0.2, 2.0, 0.0)
    wide = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Samples(values_n=pulses_n, rate_hz=1000.0)}
    yield diagnosed(fl.feasible().evolve(wide), 1.9)
    near = {"controller.kp": 0.06, "controller.ki": 2.0, "disturbance": fl.Sine(amplitude_n=0.01)}
    yield diagnosed(BENCH.evolve(near | LEVEL | {"board.ceiling_um": 0.5}), 0.5)
    lifts = {"motion.contact_s": 0.4, "motion.lifted_s": 0.2, "motion.speed_mm_s": 80.0, "motion.stroke_mm": 160.0}
    pressed = {"sensor.range_n": 1.0, "motion.load_n": 1.0, "controller.kind": "lookup"}
    yield diagnosed(BENCH.evolve(lifts | pressed), 1.0)
    yield diagnosed(BENCH.evolve({"controller.delay_s": 0.25}), 1.0)
    yield fl.doubts(BENCH.evolve({"motion.stroke_mm": 1.25, "motion.speed_mm_s": 5.0, "motion.tremor_um": 0.0}))


@raises("RECORDED-JUMPS", "RECORDED-PART", "RECORDED-ON-TOP", "RECORDED-FINGER", "TOO-FAST", "NOT-SCORED")
def recorded_runs():
    slide = 0.3 + 0.02 * np.sin(20 * AT_S) + 0.2 * (AT_S > 0.9) * (AT_S < 0.95)
    found = {"disturbance": recorded("s.csv", slide, remove_mean=True), "motion.stroke_mm": 20.0}
    yield diagnosed(BENCH.evolve(found | fl.RETUNED), 1.0)
    fast = {"disturbance": fl.Recording(path="f.csv", column="Ft", rate_hz=1e4, remove_mean=True)}
    np.savetxt("f.csv", 0.5 + 0.03 * (-1.0) ** np.arange(10_000), header="Ft", comments="")
    yield diagnosed(BENCH.evolve(fast | fl.RETUNED), 1.0)


@raises("MEAN-DOUBT", "SIGN-DOUBT", "COLUMN-DOUBT", "FINGER-OFF")
def signals():
    lifted = np.where((AT_S > 0.7) & (AT_S < 1.3), 0.001 * np.sin(500 * AT_S), 0.5 + 0.05 * np.sin(20 * AT_S))
    for slide in (
        recorded("m.csv", 0.6 + 0.05 * (np.arange(500) % 2)),
        recorded("g.csv", 0.6 * np.sign(np.sin(9 * AT_S))),
        recorded("c.csv", 0.6 + 0.05 * np.sin(9 * AT_S), "time_s,Fn [N]"),
        recorded("o.csv", lifted, remove_mean=True),
    ):
        yield fl.doubts(BENCH.evolve({"disturbance": slide}))


@raises("CARRIER-BAND", "CARRIER-OFF", "AMP-CLIPS", "EXCITATION-LOUD", "NOISE-OUTSIDE")
def parts():
    yield D.plate(overrides={"carrier.band_high_hz": 30e3})
    yield D.plate(overrides={"drive.quality_factor": 2000.0})
    yield D.sensor(overrides={"amplifier.swing_v": 7.0})
    yield D.sensor()


@raises("BEST-RINGS", "BEST-AT-END", "METRIC-NONE", "STOPPED", "PEOPLE-DRY", "OWN-RINGS", "REACH-UNKNOWN")
def sweeps():
    grid = fl.sweep(BENCH.evolve(LEVEL), {"controller.kp": list(np.geomspace(0.02, 20.0, 13))}, 0.2)
    yield fl.best(grid)
    yield fl.best(grid.assign_attrs(runs_done=5))
    yield fl.people(BENCH, 2, duration_s=0.1)
    fl.register(Ramp)
    yield fl.people(BENCH.evolve({"setpoint": Ramp()}), 2, duration_s=0.1)
    forget()


@raises("COMPARE-FEW", "OWN-FORCES", "LAW-LEFT-OUT", "LAW-CLOSE", "LAW-UNSTABLE", "LAW-LOUD", "LAW-ROUGHER")
def comparisons(monkeypatch):
    system = BENCH.evolve({"setpoint": recorded("w.csv", 0.6 + 0.1 * np.sin(9 * AT_S))})
    few = fl.compare(system, ["lookup", "retuned_pi"], 2, 0, [20.0], duration_s=1.6, progress=False)
    yield few
    # The same runs with the scores of laws that differ as few do.
    monkeypatch.setattr(law_comparison, "run_laws", lambda *_, **__: replace(few.runs, left_out={"hinf": "no order"}))
    place = {"speed_mm_s": 20.0, "slip_length_um": 0.0}

    def rows(score, *values):
        each = zip(("notch_pi", "retuned_pi"), values, strict=True)
        sizes = {"fingers": 20, "worst_decile": 1.0}
        of = [{"law": law, "score": score, "population": "capable", "median": value} for law, value in each]
        return [place | sizes | row | {"worst_decile": 2 * row["median"]} for row in of]

    scored = [*rows("residual_rms_n", 0.03, 0.025), *rows("relative_index", 2.0, 1.0)]
    scored += [row | {"population": "all"} for row in scored]
    for loud in (2.0, 99.0):
        peaks = {"sensitivity_peak": 1.5, "sensitivity_peak_5": 1.7, "sensitivity_peak_10": np.inf}
        margins = [place | peaks | {"law": "notch_pi", "sensitivity_peak_gain": loud}]
        margins += [place | peaks | {"law": "retuned_pi", "sensitivity_peak_gain": 1.9}]
        monkeypatch.setattr(law_comparison, "score_rows", lambda _: scored)
        monkeypatch.setattr(law_comparison, "margin_rows", lambda *_, rows=margins: rows)
        found = fl.compare(system)
        yield found.findings


@raises("DATA-GAPS", "CLIPPED", "COUNTER-WRAPS", "RATE-UNKNOWN", "TIMES-UNEVEN", "RESAMPLED", "NAMES-FEWER")
def channels():
    force = (0.5 + 0.1 * np.sin(9 * AT_S)) * np.where(AT_S % 2 < 1, 1, -1)
    force[77] = np.nan
    noise = np.random.default_rng(1)
    cut = np.minimum(np.sin(11 * AT_S) + 1e-3 * noise.normal(size=AT_S.size), 0.8)
    columns = np.c_[AT_S, force, np.floor(3.0 * np.arange(2000) + 100) % 2048, cut]
    np.savetxt("all.csv", columns, delimiter=",", header="time_s,Ft [N],counts,gauge [V]", comments="")
    np.savetxt("plain.csv", np.arange(100.0) ** 2, header="force", comments="")
    times = np.cumsum(1 + 0.3 * noise.uniform(-1, 1, 2000)) / 500
    np.savetxt("uneven.csv", np.c_[times, np.sin(times)], delimiter=",", header="time_s,f", comments="")
    Path("few.csv").write_text("a,b\n" + "".join(f"{k},{k * k},0.5\n" for k in range(9)))
    yield from (I.channels(name) for name in ("all.csv", "plain.csv", "uneven.csv", "few.csv"))
    yield I.findings_of(I.load("uneven.csv", resample_hz=600.0).attrs)


@raises("MODE-LEFT-OUT", "WEIGHT-LABEL")
def strange_benches():
    ring = np.exp(-AT_S * 30) * (np.sin(600 * AT_S) + np.sin(1500 * AT_S))
    np.savez("hits.npz", f_m=np.tile(np.r_[np.zeros(500), ring], 4) + 1e-4 * np.sin(np.arange(10000) ** 2), fs=1000.0)
    marks = np.array([0, 25, 50, 200, 150, 200, 250.0])
    np.savez("weights.npz", f_m=np.where(marks == 150, 2.5, marks / 50), mass=marks)
    of = '[[recording]]\nkind = "{0}"\nfiles = ["{0}.npz"]\nchannels.f_m = {{ column = "f_m", unit = "V" }}\n'
    text = of.format("hits") + of.format("weights") + 'channels.mass = { column = "mass", unit = "g" }\n'
    Path("strange.toml").write_text(text)
    yield I.bench("strange.toml")


@raises("TAKEN-FOR", "LEFT-OUT", "METHODS-DIFFER", "LINE-OFF", "NOT-TOLD", "VALUE-CHANGED", "DELAY-WAITS",
        "NOISE-DOUBT", "FEW-FINGERS")  # fmt: skip
def benches():
    path = simulated_lab.lab(Path(), "file.npz", seed=5)
    force = 9.81 * np.array([0.0, 0.05, 0.1, 0.15, 0.2, 0.15, 0.1, 0.05, 0.0])
    np.savez("again.npz", mass=force / 9.81, f_m=3.0 * force + 0.02 * force**2)
    map_ = 'channels.mass = { column = "mass", unit = "kg" }\nchannels.f_m = { column = "f_m", unit = "V" }\n'
    path.write_text(path.read_text() + f'\n[[recording]]\nkind = "weights"\nfiles = ["again.npz"]\n{map_}'
                    + f'\n[[recording]]\nkind = "hits"\nfiles = ["again.npz"]\n{map_}')  # fmt: skip
    bench = I.bench(path, without_refused=True)
    yield bench
    Path("before.json").write_text(bench.to_json())
    q = bench.measured["sensor.q"].value
    Path("after.json").write_text(bench.to_json().replace(repr(q), repr(1.1 * q)))
    yield I.compare("before.json", "after.json")
    yield I.loop_delay(rigs.jumps_rig(waits=False), 5000.0).findings
    steps = 3e-5 * np.round(np.random.default_rng(9).normal(size=20_000) / 3.0)
    time = ("time", np.arange(steps.size) / 5000.0, {"units": "s"})
    yield I.noise(xr.Dataset({"f_m": ("time", steps, {"units": "N"})}, {"time": time})).findings
    yield I.people({name: [{"friction.nominal_n": I.Estimate(f0, 0.01, "N", 9.0)}] * 2
                    for name, f0 in (("a", 0.8), ("b", 0.9), ("c", 1.2))}).findings  # fmt: skip


@raises("EFFECT-CLAMPED", "EFFECT-STEEP", "EFFECT-REACH", "EFFECT-FAINT", "EFFECT-OUT", "SCALE-TAKEN",
        "PICTURE-REDUCED", "EFFECT-LEFT")  # fmt: skip
def effects():
    bench = BENCH.evolve({"controller.kind": "notch_pi", "controller.feedforward": True})
    yield R.check(R.Grating(offset_n=0.8, amplitude_n=0.3), bench, 80.0)
    yield R.check(R.Grating(spacing_mm=0.4), bench, 80.0)
    yield R.preview(R.Grating(offset_n=0.3, amplitude_n=0.25), bench, 80.0)
    yield R.preview(R.Grating(amplitude_n=0.002), bench, 80.0)
    yield refused(R.check, R.Constant(level_n=2.0), bench)
    np.savetxt("force.csv", np.full(100, 0.4), header="force", comments="")
    yield R.import_effect("force.csv", rate_hz=1000.0)
    Image.fromarray(np.zeros((200, 300), np.uint8)).save("large.png")
    yield R.import_effect("large.png", mm_per_pixel=0.1, polarity="dark")
    event = {"Time": 0.0, "EventType": "HapticContinuous", "EventDuration": 0.1, "EventParameters": []}
    sound = {"Time": 0.0, "EventType": "AudioCustom", "EventParameters": []}
    Path("c.ahap").write_text(json.dumps({"Version": 1.0, "Pattern": [{"Event": event}, {"Event": sound}]}))
    yield R.import_effect("c.ahap", full_n=0.2)


@raises("STUDY-REACH", "STUDY-UNFITTED", "STUDY-GIVEN-UP", "STUDY-LEVELS", "STUDY-LOG", "STUDY-OUTSIDE")
def studies():
    yield X.check(X.read_protocol("magnitude-estimation").evolve({"method.levels": [1.1, 1.2]}))
    folder = X.run(
        X.read_protocol("jnd-friction-staircase").evolve({"stop.trials": 2}), Path("P"), "P", trials=1
    ).folder
    events = {"event": "adjusted", "what": "levels", "factor": 0.8}, {"event": "given up", "marked": 20}
    with (folder / "log.jsonl").open("a") as log:
        log.writelines(json.dumps(each | {"condition": "closed"}) + "\n" for each in events)
        log.write("{torn\n")
    found = X.resume(folder)
    assert (found.levels_factor, found.given_up) == (0.8, {"closed": 20})
    yield found
    yield X.report(folder)
    plan, found = X.read_protocol("jnd-friction-staircase"), {"level": ["requested"], "value": [0.5]}
    yield list(outside(plan, pandas.DataFrame(found)))


@raises(
    "BOARD-RATE",
    "BOARD-CARRIER",
    "BOARD-STEPS",
    "BOARD-POSITION",
    "BOARD-BITS",
    "CEILING-REACH",
    "FIRST-RUN",
    "TICK-LATE",
)
def boards_of_a_bench(monkeypatch):
    odd = {"plate.frequency_hz": 38200.0, "plate.q": 2000.0, "motion.stroke_mm": 80.0, "board.ceiling_um": 0.3}
    steps = {"setpoint": fl.Steps(times_s=(0.0, 1.0), levels_n=(0.4, 0.6))}
    yield fl.firmware.export(BENCH.evolve(odd | steps), "table")
    yield refused(fl.firmware.export, BENCH.evolve({"controller.rate_hz": 4400.0}), "none")
    # What compiles an image takes seconds, and is not what is looked at.
    made = image.Image(*(Path(f"t.{kind}") for kind in ("elf", "hex", "map")), 21_345, 16_789)
    monkeypatch.setattr(image, "build", lambda *_, **__: made)
    yield fl.firmware.build(BENCH, "image", trace=lambda _: {"tick": 5000, "effect": 6000})


@raises("LINE-CARRIES", "AT-CEILING", "TABLE-DIFFERS", "LINE-LOSSES", "SAMPLES-LOST", "NOT-CHECKED", "EFFECT-COARSER",
        "EFFECT-ROW", "BAD-IMAGE", "NO-DEVICE", "DEVICE-REFUSED", "DEVICE-LOST")  # fmt: skip
def devices():
    held = {"controller.kp": 0.03, "controller.ki": 60.0}
    yield fl.device.run("sim:", BENCH.evolve(held | {"board.ceiling_um": 0.5}), 0.5)
    yield fl.device.run("sim:", BENCH.evolve({"controller.rate_hz": 20_000.0}), 0.02)
    yield fl.device.info("sim:", BENCH.evolve(held))
    yield fl.device.info(connected())
    spool = Spool(
        "run.h5", {"f_m": Column("f8", {"units": "N"})}, 2e-4, {"schema": 1, "source": "device"}, ("lost_samples",)
    )
    spool.append({"f_m": np.zeros(7000)}, {"lost_samples": 3})
    content = spool.partial.read_bytes()
    spool.drop()
    Path("run.partial-1a2b3c4d.h5").write_bytes(content)
    yield fl.device.recover("run.partial-1a2b3c4d.h5")
    with fl.connect("sim:") as device:
        device.set("law.low_n", 0.2)
        device.commit()
        yield fl.device.configure(device, held)
        device.set("law.high_n", 0.1)
        yield refused(device.commit)
    rows = R.Map(values_n=((0.2, 0.4, 0.2), (0.6, 0.2, 0.3)), pitch_mm=10.0, start_mm=-10.0)
    for effect in (R.find("rough"), rows):
        yield fl.device.play("sim:", BENCH.evolve({"setpoint": {"kind": "effect", "effect": effect}}), 0.02)
    yield refused(fl.device.flash, "none.elf")
    yield refused(fl.device.info, "serial:///dev/none")
    device = connected()
    device.close()
    yield refused(device.run, 0.5, 0.1)


@raises(*(fault_code(number) for number in FAULTS if number))
def faults():
    for number, name in FAULTS.items():
        if number:
            board = boards().Board()
            device = connected(board)
            with pytest.raises(fl.Interrupted) as ended:
                device.run(0.5, 0.2, progress=lambda _, board=board, name=name: board.raise_fault(name))
            yield ended.value


def codes_of(found: Any) -> set[str]:
    """Return the codes of an answer, of an error, or of findings by themselves."""
    if isinstance(found, (tuple, list)):
        return {each.code for each in found}
    return {each.code for each in found.findings} if isinstance(found, Result) else {found.code}


@pytest.mark.filterwarnings("ignore::frictionloop.SignalWarning")
@pytest.mark.parametrize("name", CALLS)
def test_codes_are_raised_and_stand_in_every_form(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, codes = CALLS[name]
    raised = set()
    for found in call(*[monkeypatch] * call.__code__.co_argcount):
        raised |= codes_of(found)
        if isinstance(found, Result):
            every = "\n".join("".join(text for text, _ in line) for line in lines(found, everything=True))
            told = {each["code"] for each in json.loads(found.to_json())["findings"]}
            assert told == codes_of(found)
            for form in (every, found.to_html(), found._repr_html_()):
                assert all(code in form for code in told)
    assert not {*codes} - raised, f"raised instead: {sorted(raised)}"


def test_every_code_of_the_catalogue_is_raised():
    declared = [code for _, codes in CALLS.values() for code in codes]
    assert len(declared) == len({*declared}), "a code has one call"
    assert {*CATALOGUE} == {*declared}
