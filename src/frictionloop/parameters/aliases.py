"""Names that people try for a parameter, and what it is called here, with the conversion where they differ."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from frictionloop.quantities.units import UNITS, unit_of

Convert = Callable[[float, Mapping[str, Any]], float]
"""The value under the name of this package, from the one given and the other values of the block."""


class Guess(NamedTuple):
    """Some words for one thing."""

    words: str
    fields: str
    """What it is called here; the first of them that the block has."""
    how: str = ""
    """The conversion in words, "" for none, with the other values of the block that it takes."""
    convert: Convert = lambda value, _: value


GUESSES = (
    Guess("damping damping_ratio zeta xi", "q", "Q = 1/(2 damping)", lambda v, _: 0.5 / v),
    Guess(
        "log_decrement logarithmic_decrement decrement log_dec delta", "q", "Q = pi/decrement", lambda v, _: math.pi / v
    ),
    Guess("loss_factor loss eta", "q", "Q = 1/loss factor", lambda v, _: 1.0 / v),
    Guess("quality quality_factor q_factor resonance_q", "q"),
    Guess(
        "omega omega_n omega0 omega_0 wn w0 w_n", "resonance_hz frequency_hz", "omega/(2 pi)", lambda v, _: v / math.tau
    ),
    Guess(
        "natural_frequency natural_freq f0 f_0 fn f_n fres f_res fr resonance resonant_frequency resonance_frequency "
        "resonance_freq eigenfrequency first_resonance frequency freq carrier",
        "resonance_hz frequency_hz",
    ),
    Guess("k stiffness spring spring_constant spring_stiffness", "stiffness_n_m"),
    Guess("contact", "slip_length_um", "0 of a slider"),
    Guess("bristle_stiffness", "slip_length_um", "0.6 N over the stiffness", lambda v, _: 0.6 / v),
    Guess("compliance compliance_um_per_n", "slip_length_um", "0.6 N times the compliance", lambda v, _: 0.6 * v),
    Guess("skin_stiffness_n_m", "slip_length_um", "of the contact", lambda v, _: math.nan),
    Guess("learning_s susceptibility_spread", "susceptibility_margin", "not learnt", lambda v, _: math.nan),
    Guess("bristle_damping", "slip_length_um", "the contact has no damper", lambda v, _: math.nan),
    Guess(
        "k stiffness spring spring_constant spring_stiffness stiffness_n_m",
        "resonance_hz",
        "sqrt(stiffness/mass)/(2 pi), moving_mass_kg = {moving_mass_kg:g}",
        lambda v, block: math.sqrt(v / block["moving_mass_kg"]) / math.tau,
    ),
    Guess("bandwidth pole pole_frequency corner corner_frequency fc f_c lowpass low_pass cut_off filter", "cutoff_hz"),
    Guess("time_constant tau pole_s", "cutoff_hz", "1/(2 pi tau)", lambda v, _: 1.0 / (math.tau * v)),
    Guess("noise_density density asd noise_asd nsd", "noise_density_n_rthz"),
    Guess("noise noise_rms rms_noise noise_std sigma noise_sigma", "noise_rms_n"),
    Guess(
        "noise noise_rms rms_noise noise_std sigma noise_sigma noise_rms_n",
        "noise_density_n_rthz",
        "a density: rms / sqrt(pi/2 cutoff_hz), cutoff_hz = {cutoff_hz:g}",
        lambda v, block: v / math.sqrt(math.pi / 2.0 * block["cutoff_hz"]),
    ),
    Guess("gain p k_p p_gain proportional proportional_gain kp_gain", "kp"),
    Guess("i k_i i_gain integral integral_gain ki_gain", "ki"),
    Guess("ti t_i integral_time", "ki", "Kp/Ti, kp = {kp:g}", lambda v, block: block["kp"] / v),
    Guess("d kd k_d td t_d derivative derivative_gain", "kp", "no law has a derivative term", lambda v, _: math.nan),
    Guess(
        "ts t_s dt period sample_time sampling_time sample_period sampling_period control_period",
        "rate_hz",
        "1/Ts",
        lambda v, _: 1.0 / v,
    ),
    Guess(
        "sample_rate sampling_rate samplerate sampling_frequency sample_frequency fs f_s control_rate loop_rate "
        "update_rate control_frequency loop_frequency frequency freq",
        "rate_hz",
    ),
    Guess("latency dead_time deadtime lag transport_delay input_delay loop_delay time_delay", "delay_s"),
    Guess(
        "delay_samples delay_periods delay_ticks latency_samples latency_periods latency_ticks",
        "delay_s",
        "periods/rate_hz, rate_hz = {rate_hz:g}",
        lambda v, block: v / block["rate_hz"],
    ),
    Guess("mass m suspended_mass plate_mass moving_mass", "moving_mass_kg mass_kg"),
    Guess("amplitude max_amplitude a_max vibration", "max_amplitude_um"),
    Guess(
        "peak_to_peak amplitude_pp max_amplitude_pp amplitude_p2p amplitude_pk_pk vibration_pp",
        "max_amplitude_um",
        "zero-to-peak, half of peak-to-peak",
        lambda v, _: v / 2.0,
    ),
    Guess("range full_scale fullscale max_force force_range", "range_n"),
    Guess("bits resolution resolution_bits adc", "adc_bits"),
    Guess("speed velocity v finger_speed finger_velocity", "speed_mm_s"),
    Guess("load normal_force force normal n pressing_force", "load_n"),
    Guess(
        "mu cof coefficient friction_coefficient",
        "nominal_n",
        "a force: mu times the load",
        lambda v, block: v * block.get("reference_load_n", 1.0),
    ),
    Guess("f0 friction force nominal static", "nominal_n"),
    Guess("tau susceptibility", "susceptibility_per_um2"),
)
"""In this order: the first whose field the block has is told."""
_SAME = Guess("", "")
_SUFFIX = re.compile(r"(?<=[a-z0-9])_(n_rthz|n_s_m|n_m|per_um2|mm_s|m_s|[km]?hz|[mu]?s|[mu]?n|k?g|[mun]?m|m?v)$")
_SCALES = {unit.lower().replace("/", "_"): (kind, scale) for unit, (kind, scale) in UNITS.items()}
_SCALES |= {"hz": ("Hz", 1.0), "khz": ("Hz", 1e3), "mhz": ("Hz", 1e6), "um": ("m", 1e-6), "nm": ("m", 1e-9)}


class Meant(NamedTuple):
    """A parameter that a name may have been meant for, its value if that is known, and the conversion in words."""

    name: str
    value: float | None = None
    how: str = ""

    def __str__(self) -> str:
        """Return what to write in the place of the name."""
        unit = unit_of(self.name)
        if self.value is None:
            return f"{self.name} ({'; '.join(filter(None, [unit, self.how]))})".removesuffix(" ()")
        return f"{self.name} = {self.value:.6g}{unit and ' '}{unit}" + (f" ({self.how})" if self.how else "")


def meant(path: str, given: Any, names: list[str], block: Mapping[str, Any]) -> Meant | None:
    """Return the parameter that a name stands for, None if it is none of those that people try."""
    above, _, leaf = path.rpartition(".")
    leaf = leaf.lower()
    word, unit = _parts(leaf)
    near = sorted((each for each in names if each.startswith(f"{above}." if above else "")), key=lambda n: n.count("."))
    for name in near:  # the same word, without its unit or in another one
        own, its = _parts(name.rpartition(".")[2])
        if own == word and (unit in ("", its) or _kind(unit) == _kind(its) != ""):
            return Meant(name) if unit in ("", its) else _converted(name, _SAME, unit, given, block)
    for guess in GUESSES:
        found = [n for field in guess.fields.split() for n in near if n.rpartition(".")[2] == field]
        said = guess.words.split()
        if found and (leaf in said or (word in said and (guess.how or _kind(unit) == _kind_of(found[0])))):
            return _converted(found[0], guess, unit if leaf not in said else "", given, block)
    return None


def _parts(leaf: str) -> tuple[str, str]:
    """Return a name without its unit, and the unit."""
    found = _SUFFIX.search(leaf)
    return (leaf[: found.start()], found[1]) if found else (leaf, "")


def _kind(unit: str) -> str:
    return _SCALES.get(unit, ("", 1.0))[0]


def _kind_of(name: str) -> str:
    return _kind(_parts(name.rpartition(".")[2])[1])


def _converted(name: str, guess: Guess, unit: str, given: Any, block: Mapping[str, Any]) -> Meant:
    try:
        how = guess.how.format(**block)
    except (KeyError, ValueError):
        how = guess.how.partition(", ")[0]
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not (how or unit):
        return Meant(name, None, how)
    own = _SCALES.get(_parts(name.rpartition(".")[2])[1], ("", 1.0))[1]
    try:
        value = guess.convert(given * (_SCALES[unit][1] if unit else own), block) / own
    except (KeyError, TypeError, ValueError, ArithmeticError):
        value = math.nan
    return Meant(name, value if math.isfinite(value) else None, how)
