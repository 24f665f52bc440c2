"""Rigs (d) and (e): the plate alone under a vibrometer, and known jumps at the controller's input."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.special import ndtr

from frictionloop.parameters import ResonantPlate
from frictionloop.quantities import Array
from frictionloop.quantities.counter_noise import normals

PLATE_STREAM = 31
JUMP_STREAM = 33


def plate_sweep_rig(
    plate: ResonantPlate | None = None,
    frequencies_hz: Sequence[float] | None = None,
    noise_um: float = 5e-3,
    seed: int = 0,
) -> xr.Dataset:
    """Return a table of stepped sines: ``frequency`` in Hz, ``vibration`` in um, over ``row``.

    A(f) = A_max / (Q sqrt((1 - (f/f0)^2)^2 + (f/(f0 Q))^2)), and white noise on each row.

    Parameters
    ----------
    plate : ResonantPlate, optional
        Resonance, Q and largest amplitude; None is that of ``fl.bench()``.
    frequencies_hz : sequence of float, optional
        Where to measure; None is 31 steps over three widths of the resonance.
    noise_um : float
        Standard deviation of a row in um (assumed).
    seed : int
        Seed of the noise.
    """
    plate = plate or ResonantPlate()
    middle, width = plate.frequency_hz, plate.frequency_hz / plate.q
    hertz = np.asarray(
        np.linspace(middle - 1.4 * width, middle + 1.6 * width, 31) if frequencies_hz is None else frequencies_hz
    )
    relative = hertz / middle
    amplitude = plate.max_amplitude_um / plate.q / np.hypot(1 - relative**2, relative / plate.q)
    amplitude = amplitude + noise_um * normals(seed, PLATE_STREAM, 0, hertz.size)
    return xr.Dataset(
        {"frequency": ("row", hertz, {"units": "Hz"}), "vibration": ("row", amplitude, {"units": "um"})},
        attrs={"source": "simulated"},
    )


def plate_switch_rig(
    plate: ResonantPlate | None = None,
    switches: int = 4,
    detuning_hz: float = 0.0,
    rate_hz: float = 200e3,
    between_s: float = 0.02,
    noise_um: float = 5e-3,
    seed: int = 0,
) -> xr.Dataset:
    """Return ``vibration`` and ``envelope`` in um over ``time``, the drive switched on and off in turn.

    The complex amplitude z follows z' = -(s + j d) z + s u with s = pi f0/Q and d the detuning as an angle, exactly
    while u is held; the vibration is Re z e^(j w t) at the drive's frequency, noise is white.

    Parameters
    ----------
    plate : ResonantPlate, optional
        Resonance, Q and largest amplitude; None is that of ``fl.bench()``.
    switches : int
        How often the drive is switched, on first.
    detuning_hz : float
        Drive less resonance in Hz.
    rate_hz : float
        Samples per second.
    between_s : float
        Time from switch to switch in s.
    noise_um : float
        Standard deviation of a sample in um (assumed).
    seed : int
        Seed of the noise.
    """
    plate = plate or ResonantPlate()
    each = round(between_s * rate_hz)
    pole = -(math.pi * plate.frequency_hz / plate.q) + 2j * math.pi * -detuning_hz
    steps = np.exp(pole * np.arange(1, each + 1) / rate_hz)
    z, parts = 0j, []
    for k in range(switches + 1):
        held = plate.max_amplitude_um * (pole.real / pole) * (k % 2)
        parts.append(held + (z - held) * steps)
        z = complex(parts[-1][-1])
    amplitude = np.concatenate(parts)
    time = np.arange(amplitude.size) / rate_hz
    noise = noise_um * normals(seed, PLATE_STREAM + 1, 0, 2 * time.size).reshape(2, -1)
    # A mode decays at its damped frequency, which the drive is off by the detuning.
    damped_hz = plate.frequency_hz * math.sqrt(1 - 1 / (4 * plate.q**2))
    carrier = np.exp(2j * math.pi * (damped_hz + detuning_hz) * time)
    vibration, envelope = (amplitude * carrier).real + noise[0], np.abs(amplitude) + noise[1]
    return _over_time(time, "um", vibration=vibration, envelope=envelope)


def _over_time(time: Array, unit: str, **channels: Array) -> xr.Dataset:
    data = {name: ("time", values, {"units": unit}) for name, values in channels.items()}
    return xr.Dataset(data, {"time": ("time", time, {"units": "s"})}, {"source": "simulated"})


def jumps_rig(
    delay_s: float = 200e-6,
    control_hz: float = 5000.0,
    plate_hz: float | None = 100.0,
    jumps: int = 12,
    rate_hz: float = 100e3,
    noise: float = 1e-3,
    waits: bool = True,
    seed: int = 0,
) -> xr.Dataset:
    """Return ``jump`` and ``answer`` in V over ``time``: steps of 1 V up and down, answered once they were sampled.

    The controller samples every 1/control_hz; a jump is answered ``delay_s`` after the first sample that sees it, by a
    step that the plate's low-pass rounds.

    Parameters
    ----------
    delay_s : float
        From the sample to the new command, in s.
    control_hz : float
        Control rate in Hz.
    plate_hz : float, optional
        Cutoff of the plate's envelope in Hz; None: the answer is the command itself.
    jumps : int
        Number of jumps.
    rate_hz : float
        Samples per second.
    noise : float
        Standard deviation of a sample of the answer in V (assumed).
    waits : bool
        Whether jumps come at any time of a control period; False: just before a sample.
    seed : int
        Seed of times and noise.
    """
    between = 0.04
    time = np.arange(round((jumps + 1) * between * rate_hz)) / rate_hz
    spread = ndtr(normals(seed, JUMP_STREAM, 0, jumps)) if waits else np.zeros(jumps)
    jump, answer = np.zeros_like(time), np.zeros_like(time)
    for k in range(jumps):
        begins = between * (k + 0.5) + spread[k] / control_hz
        sampled = math.ceil(begins * control_hz - 1e-9) / control_hz
        sign = 1 - 2 * (k % 2)
        jump += sign * (time >= begins)
        late = np.maximum(time - sampled - delay_s, 0.0)
        answer += sign * (late > 0 if plate_hz is None else -np.expm1(-2 * math.pi * plate_hz * late))
    answer += noise * normals(seed, JUMP_STREAM + 1, 0, time.size)
    return _over_time(time, "V", jump=jump, answer=answer)
