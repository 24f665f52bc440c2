"""The analog chain as a SPICE netlist: both sides from the excitation to the demodulated, filtered difference.

Node ``x`` is the displacement, 1 V for 1 um. Op-amps are one pole with an input noise resistor; everything is written
in elements that ngspice knows, and in the linear part (up to ``p_bp`` and ``m_bp``) only R, C, L, G and E.
"""

from __future__ import annotations

import math
import os

import numpy as np
from scipy.constants import Boltzmann

from frictionloop.hardware.sensor import front_end
from frictionloop.hardware.sensor.front_end import capacitance_f
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import replacing

ABSOLUTE_ZERO_C = -273.15


def write_spice(design: SensorDesign, path: str | os.PathLike[str]) -> None:
    """Write the netlist of a sensor design to a file, replaced if it is there."""
    with replacing(path) as beside:
        beside.write_text(to_spice(design), encoding="utf-8")


def to_spice(design: SensorDesign) -> str:
    """Return the analog chain of a sensor design as a netlist without analyses, ending in ``.end``.

    Sources: ``Vexc`` (excitation: AC 1, and the sine in time), ``Vx`` (displacement, 1 V = 1 um, 0 by default). Nodes
    of side ``p`` (plus) and ``m`` (minus): ``p_ca`` charge amplifier, ``p_bp`` band-pass, ``p_out`` demodulated and
    low-passed; ``diff`` is their difference. Put ``.ac``, ``.tran`` or ``.noise`` lines before ``.end``. Clipping is
    not modelled: ``waveform`` has it.
    """
    excitation = design.excitation
    celsius = design.environment.temperature_k + ABSOLUTE_ZERO_C
    around = f"201 {_number(0.9 * excitation.frequency_hz)} {_number(1.1 * excitation.frequency_hz)}"
    phase_deg = float(np.degrees(np.angle(front_end.carrier_gain(design))))
    lines = [
        "* capacitive force sensor, frictionloop",
        "* V(x): 1 V = 1 um",
        f"* try: .ac lin {around}",
        f"* try: .noise v(p_bp) Vexc lin {around}",
        f"* try: .tran {_number(1 / (64 * excitation.frequency_hz))} 5m",
        f"Vexc exc 0 DC 0 AC 1 SIN(0 {_number(excitation.amplitude_v)} {_number(excitation.frequency_hz)})",
        "Vx x 0 DC 0",
        "* demodulator's reference",
        f"Vref ref 0 DC 0 SIN(0 -2 {_number(excitation.frequency_hz)} 0 0 {_number(phase_deg)})",
        *_opamp(design),
    ]
    rest = capacitance_f(design)
    for name, capacitance, approach in (("p", rest.plus, "-"), ("m", rest.minus, "+")):
        lines += ["", *_side(design, name, capacitance, approach)]
    lines += [
        "",
        "Ediff diff 0 p_out m_out 1",
        "* temperature of the noise",
        f".options temp={_number(celsius)} tnom={_number(celsius)}",
        ".end",
    ]
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """Return a number as SPICE reads it: no suffix, nine digits."""
    return f"{value:.9g}"


def _noise_resistor_ohm(design: SensorDesign, noise_nv_rthz: float) -> float:
    """Return the resistor whose thermal noise has this density."""
    return (noise_nv_rthz * 1e-9) ** 2 / (4 * Boltzmann * design.environment.temperature_k)


def _opamp(design: SensorDesign) -> list[str]:
    amplifier = design.amplifier
    turn = 2 * math.pi * amplifier.gain_bandwidth_mhz * 1e6
    return [
        "",
        "* wt/(s + wt/A0)",
        ".subckt opamp inp inn out",
        "Gin 0 pole inp inn 1",
        f"Gloss pole 0 pole 0 {_number(1 / amplifier.open_loop_gain)}",
        f"Cpole pole 0 {_number(1 / turn)}",
        "Eout out 0 pole 0 1",
        ".ends",
    ]


def _side(design: SensorDesign, name: str, capacitance_f_: float, approach: str) -> list[str]:
    amplifier, filters = design.amplifier, design.filters
    parts = front_end.bandpass_parts(design)
    gap = _number(design.electrodes.gap_um)
    lines = [
        f"Cs_{name} exc {name}_in Q='{_number(capacitance_f_)}*V(exc,{name}_in)/(1{approach}V(x)/{gap})'",
        *([f"Cpar_{name} {name}_in 0 {_number(amplifier.parasitic_pf * 1e-12)}"] if amplifier.parasitic_pf else []),
        f"Cf_{name} {name}_in {name}_ca {_number(amplifier.feedback_pf * 1e-12)}",
        f"Rf_{name} {name}_in {name}_ca {_number(amplifier.feedback_mohm * 1e6)}",
    ]
    if amplifier.current_noise_fa_rthz:
        # A resistor with this noise current would load the input; its noise is copied by a source instead.
        ohm = _noise_resistor_ohm(design, amplifier.current_noise_fa_rthz * 1e3)
        lines += [f"Rin_{name} {name}_ni 0 {_number(ohm)}", f"Gin_{name} {name}_in 0 {name}_ni 0 1e-9"]
    lines += [
        *_noisy_input(design, amplifier.noise_nv_rthz, f"{name}_np", f"Ren_{name}"),
        f"Xca_{name} {name}_np {name}_in {name}_ca opamp",
        f"Rbp_{name} {name}_ca {name}_t {_number(parts.resistor_ohm)}",
        f"Lbp_{name} {name}_t 0 {_number(parts.coil_h)}",
        f"Cbp_{name} {name}_t 0 {_number(parts.capacitor_f)}",
        *_noisy_input(design, filters.buffer_noise_nv_rthz, f"{name}_nb", f"Rbuf_{name}"),
        f"Ebuf_{name} {name}_bp {name}_nb {name}_t 0 1",
        f"Bdem_{name} {name}_dem 0 V=V({name}_bp)*V(ref)",
        f"Rlp_{name} {name}_dem {name}_out {_number(front_end.lowpass_resistor_ohm(design))}",
        f"Clp_{name} {name}_out 0 {_number(filters.lowpass_nf * 1e-9)}",
    ]
    return lines


def _noisy_input(design: SensorDesign, noise_nv_rthz: float, node: str, resistor: str) -> list[str]:
    """Return a source of voltage noise to ground at ``node``; nothing flows through it."""
    if not noise_nv_rthz:
        return [f"V{resistor} {node} 0 DC 0"]
    return [f"{resistor} {node} 0 {_number(_noise_resistor_ohm(design, noise_nv_rthz))}"]
