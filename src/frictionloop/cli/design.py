"""``frictionloop design``: find a controller, check one, say what limits a bench, size plate and sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb

ASKED = Group("What must hold", sort_key=2)
MOST_FINGERS = 100_000
"""More than a population needs for the worst of a thousand, at some 0.1 s each."""


def _asked(said: str) -> Parameter:
    return Parameter(group=ASKED, help=said)


@Parameter(name="*")
@dataclass(frozen=True)
class MustHold:
    """Limits, and how far the bench may be from what is written down.

    What is not given is as the file was designed for, else as the default of `fl.design.Requirements`.
    """

    sensitivity_peak: Annotated[float | None, _asked("Largest Ms = max |1/(1 + G)| as described; 1.7.")] = None
    resonance_error: Annotated[float | None, _asked("Share by which the resonance may be off; 0.05.")] = None
    sensor_error: Annotated[float | None, _asked("The same of the electronics' pole; 0.")] = None
    delay_error: Annotated[float | None, _asked("The same of the delay; 0.")] = None
    gain_error: Annotated[float | None, _asked("The same of the sensitivity; 0.")] = None
    q_error: Annotated[float | None, _asked("The same of the Q; 0.")] = None
    corners: Annotated[Path | None, _asked("Certificate of ``identify bench``, whose intervals count.")] = None
    speeds: Annotated[str | None, _asked("Slowest and fastest stroke in mm/s: 20,60, or one; that of FILE.")] = None
    slip_lengths_um: Annotated[
        str | None, _asked("Least and largest slip length in um: 0,30, or one; 0 to that of FILE.")
    ] = None
    loads: Annotated[str | None, _asked("Least and largest mean load in N: 0.4,1.2, or one; that of FILE.")] = None
    finger_gain: Annotated[
        float | None, _asked("Largest loop gain over the believed one; controller.model.gain_spread.")
    ] = None

    def requirements(self, file: Path | None) -> Any:
        """Return the same for a design: what is not given is as in the file's table [designed]."""
        speeds = file_arguments.two_values("speeds", self.speeds, "mm/s, such as 20,60, or one")
        loads = file_arguments.two_values("loads", self.loads, file_arguments.LOADS)
        lengths = file_arguments.two_values(
            "slip_lengths_um", self.slip_lengths_um, "um, such as 0,30, or one", zero=True
        )
        shares = (
            "sensitivity_peak",
            "resonance_error",
            "sensor_error",
            "delay_error",
            "gain_error",
            "q_error",
            "finger_gain",
        )
        given: dict[str, Any] = {name: value for name in shares if (value := getattr(self, name)) is not None}
        ranges = {"speeds_mm_s": speeds, "loads_n": loads, "slip_lengths_um": lengths}
        given |= {name: tuple(dict.fromkeys(ends)) for name, ends in ranges.items() if ends}
        if self.corners is not None:
            shared = {"sensor.resonance_hz": self.resonance_error, "sensor.cutoff_hz": self.sensor_error}
            shared |= {"controller.delay_s": self.delay_error, "sensor.q": self.q_error}
            ends = fl.identify.certified_corners(self.corners)
            given["ends"] = tuple((each.path, each.value) for each in ends if not shared.get(each.path))
        table = None if file is None else fl.design.read_designed(file)
        return fl.design.Requirements(**({} if table is None else table.requirements.changes) | given)


@Parameter(name="*")
@dataclass(frozen=True)
class MustHoldForPeople(MustHold):
    """The same, on other people's fingers too."""

    fingers: Annotated[flags.Whole | None, _asked("So many random fingers besides.")] = None
    fingers_seed: Annotated[flags.Whole | None, _asked("Seed of the fingers; 0.")] = None
    coefficients: Annotated[str | None, _asked("Their least and largest friction coefficient: 0.4,1.2.")] = None
    population: Annotated[Path | None, _asked("Measured population (.toml) they are drawn from.")] = None

    def check(self) -> None:
        """Refuse a number or a seed out of range, and what says where fingers come from without any."""
        whose = {"population": self.population, "coefficients": self.coefficients}
        file_arguments.check_fingers(self.fingers, self.fingers_seed, MOST_FINGERS, **whose)

    def people(self, system: fl.System, overrides: list[str] | None) -> Sequence[Any] | None:
        """Return the fingers; None if none are asked for."""
        if not self.fingers:
            return None
        coefficients = file_arguments.two_values("coefficients", self.coefficients, file_arguments.COEFFICIENTS) or None
        of = {"population": self.population, "coefficients": coefficients, "given": flags.overrides_of(overrides)}
        return fl.fingers_for(system, self.fingers, self.fingers_seed or 0, **of)


AS_USUAL = MustHoldForPeople()


@verb(
    "controller [FILE] [OPTIONS]",
    "",
    "my-bench.toml --out my-controller.toml",
    "my-bench.toml --speeds 20,60 --loads 0.4,1.2",
    "my-bench.toml --corners certificate.html",
    "my-bench.toml --law hinf --sensitivity-peak 1.5 --resonance-error 0.1 --plots figures",
)
def controller(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    law: Annotated[str | None, Parameter(group=ASKED)] = None,
    must: MustHoldForPeople = AS_USUAL,
    out: flags.Result[Path | None] = None,
    plots: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> int:
    """Find a controller for a bench: gains, margins on every finger and resonance, and what is left to gain.

    Parameters
    ----------
    law
        Control law: notch_pi, pi, limit_observer or hinf; notch_pi if not given, pi for
        a force sensor without a resonance.
    out
        Write the system with its new controller here (.toml).
    plots
        Folder for figures, sensitivity and step, each as .svg and .png.
    """
    must.check()
    file_arguments.check_output("out", out, file_arguments.SYSTEMS, new=True)
    file_arguments.check_folder("plots", plots)
    given = flags.system_given(file, preset, overrides, "bench", designed=law or "notch_pi")
    requirements, people = must.requirements(file), must.people(given.system, overrides)
    with fl.progress.waiting("designing" + f" {law}" * bool(law)):
        found = fl.design.controller(given.system, law, requirements, people, given=given.stated)
    if out is not None:
        fl.design.write_controller(found, out, given.stated)
    if plots is not None:
        file_arguments.write_figures("plots", plots, {name: found.plot(name) for name in ("sensitivity", "step")})
    shown.show(found.with_findings(given.findings), saved={"controller": out, "figures": plots})
    return 0 if found.holds else screen.DOES_NOT_HOLD


@verb(
    "check [FILE] [OPTIONS]",
    "my-controller.toml",
    "my-bench.toml --controller.kp 0.05 --controller.ki 60",
    "my-controller.toml --speeds 20,60 --json",
    "my-controller.toml --fingers 100 --all",
)
def check(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    must: MustHoldForPeople = AS_USUAL,
    out: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> int:
    """Check the controller of a system as it is: where it holds, where it does not and by how much, and what would.

    No other controller is searched for. It is looked at from slip length 0 to its own, at its speed, half and four
    times that, on a dry and a moist finger, with the resonance off.

    Parameters
    ----------
    out
        Write the system with this controller here (.toml), with what was found.
    """
    must.check()
    file_arguments.check_output("out", out, file_arguments.SYSTEMS, new=True)
    given = flags.system_given(file, preset, overrides, "bench")
    requirements, people = must.requirements(file), must.people(given.system, overrides)
    with fl.progress.waiting(f"checking {given.system.controller.kind}"):
        found = fl.design.check(given.system, requirements, people, given=given.stated)
    if out is not None:
        fl.design.write_controller(found, out, given.stated)
    shown.show(found.with_findings(given.findings), saved={"controller": out})
    return 0 if found.holds else screen.DOES_NOT_HOLD


BENCH_AS_USUAL = MustHold()


@verb("limits [FILE] [OPTIONS]", "my-bench.toml", "my-bench.toml --law limit_observer --plot limits.svg")
def limits(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    law: Annotated[str | None, Parameter(group=ASKED)] = None,
    must: MustHold = BENCH_AS_USUAL,
    plot: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Find a controller for a bench with one part changed at a time: what each would leave.

    Parameters
    ----------
    law
        Control law, as of design controller.
    plot
        Write bars of what is left here (.svg, .pdf or .png).
    """
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    given = flags.system_given(file, preset, overrides, "bench", designed=law or "notch_pi")
    with fl.progress.waiting("designing benches with one part changed"):
        found = fl.design.limits(given.system, law, must.requirements(file))
    if plot is not None:
        file_arguments.write_figure(plot, found.plot())
    shown.show(found.with_findings(given.findings), saved={"figure": plot})


Plate = Annotated[flags.T, Parameter(group=Group("Plate", sort_key=1))]
Sized = Annotated[flags.T, Parameter(group=Group("Asked", sort_key=2))]


@verb(
    "plate [OPTIONS]",
    "",
    "--frequency-hz 40000 --bandwidth-hz 150",
    "--drive.finger-on true --drive.quality-factor 120",
)
def plate(
    *,
    overrides: Annotated[Plate[list[str] | None], Parameter(name=flags.DOTTED, metavar="VALUE")] = None,
    frequency_hz: Sized[float | None] = None,
    bandwidth_hz: Sized[float | None] = None,
    check_carrier: Sized[flags.Flag] = False,
    readings: Sized[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Say how a plate vibrates, what drives it, what a finger and the carrier change; with its [plate] block.

    Parameters
    ----------
    overrides
        Any parameter of the plate by its dotted name, such as --geometry.thickness-mm 4 or
        --drive.quality-factor 150. --json lists the names.
    frequency_hz
        Resonance wanted, in Hz: which mode, which thickness. All else is then of that mode, unless
        --geometry.nodal-lines names another.
    bandwidth_hz
        Envelope bandwidth wanted, in Hz: which Q.
    check_carrier
        Simulate the carrier and say how far the first-order envelope is off.
    readings
        Say which of the paper's numbers go together.
    """
    own = flags.overrides_of(overrides)
    asked = {"frequency_hz": frequency_hz, "bandwidth_hz": bandwidth_hz}
    with fl.progress.waiting("simulating the carrier" if check_carrier else "sizing a plate"):
        found = fl.design.plate(overrides=own, **asked, check_carrier=check_carrier, readings=readings)
    shown.show(found)


Design = Annotated[flags.T, Parameter(group=Group("Design", sort_key=1))]
Wanted = Annotated[flags.T, Parameter(group=Group("Requirement, for which a geometry is searched", sort_key=2))]


@verb(
    "sensor [FILE] [OPTIONS]",
    "",
    "--electrodes.gap_um 150 --adc.bits 13",
    "--resonance-hz 145 --range-n 2.5 --noise-rms-n 5e-5 --save-design my-sensor.toml",
    "my-sensor.toml --spice my-sensor.cir",
)
def sensor(
    file: Annotated[Design[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    overrides: Annotated[Design[list[str] | None], Parameter(name=flags.DOTTED, metavar="VALUE")] = None,
    resonance_hz: Wanted[float | None] = None,
    range_n: Wanted[float | None] = None,
    noise_rms_n: Wanted[float | None] = None,
    noise_density_n_rthz: Wanted[float | None] = None,
    save_design: flags.Result[Path | None] = None,
    spice: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Size the force sensor: springs, electrodes and electronics to resonance, range and noise, or back.

    Parameters
    ----------
    file
        TOML file with what differs from the built-in design.
    overrides
        Any parameter of the design by its dotted name, such as --electrodes.gap_um 150 or --springs.kind
        straight. --save-design lists the names.
    resonance_hz
        First resonance in Hz; that of the design if not given.
    range_n
        Largest force in N; that of the design if not given.
    noise_rms_n
        Noise of the output at rest in N rms; 5e-5 if not given.
    noise_density_n_rthz
        Instead: noise density of the electronics in N/rtHz.
    save_design
        Write the design here (.toml): a start for your own.
    spice
        Write the analog chain here as a netlist for ngspice (.cir).
    """
    file_arguments.check_output("save_design", save_design, file_arguments.SYSTEMS, new=True)
    file_arguments.check_output("spice", spice, (".cir",))
    wanted = {"resonance_hz": resonance_hz, "range_n": range_n}
    wanted |= {"noise_rms_n": noise_rms_n, "noise_density_n_rthz": noise_density_n_rthz}
    found = fl.design.sensor(file, flags.overrides_of(overrides), **wanted)
    if save_design is not None:
        fl.write_toml(found.design, save_design)
    if spice is not None:
        fl.design.write_spice(found.design, spice)
    shown.show(found, saved={"design": save_design, "netlist": spice})
