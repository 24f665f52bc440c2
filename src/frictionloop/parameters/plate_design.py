"""What a builder chooses for the ultrasonic plate: glass, size and mode, drive, piezo patches, finger, carrier."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole
from frictionloop.parameters.frozen_blocks import Description
from frictionloop.quantities import must_be

Side = Literal["length", "width"]
"""The side along which the standing wave runs; its nodal lines are parallel to the other side."""


class Glass(Block):
    """Elastic constants of the plate; the defaults are those of soda-lime glass."""

    young_modulus_pa: Positive = 72e9
    """Young's modulus E in Pa (assumed: soda-lime)."""
    poisson_ratio: Annotated[Number, Field(ge=0, lt=0.5)] = 0.22
    """Poisson's ratio nu (assumed: soda-lime)."""
    density_kg_per_m3: Positive = 2500.0
    """Density rho in kg/m^3 (assumed: soda-lime)."""


class PlateGeometry(Block):
    """Size of the plate and the mode it vibrates in."""

    length_mm: Positive = 255.0
    """Longer side (paper, Sec. 4.1)."""
    width_mm: Positive = 140.0
    """Shorter side (paper, Sec. 4.1)."""
    thickness_mm: Positive = 3.0
    """Thickness h (paper, Sec. 4.1)."""
    nodal_lines: Annotated[Whole, Field(ge=2)] = 12
    """Nodal lines N of the mode; the printed 16 does not go with 3 mm and 46 kHz (physics.plate_readings)."""
    wave_along: Side = "width"
    """Side along which the nodal lines follow each other (assumed, see nodal_lines)."""

    @property
    def side_mm(self) -> float:
        """Length of the side along which the wave runs."""
        return self.length_mm if self.wave_along == "length" else self.width_mm


class PlateDrive(Block):
    """How the resonance is driven."""

    finger_on: bool = False
    """Whether quality_factor and max_amplitude_um are those with a finger on the plate."""
    quality_factor: Annotated[Number, Field(gt=0.5)] = 230.0
    """Q of the mode (assumed: gives the envelope of 100 Hz of Sec. 2.2 at 46 kHz)."""
    resonance_hz: Positive | None = None
    """Measured resonance; left out, the mode's own by the exact theory."""
    detuning_hz: Number = 0.0
    """Carrier frequency less resonance, before the timer rounds it (assumed)."""
    max_amplitude_um: Positive = 2.5
    """Amplitude at full drive, zero-to-peak (paper, Sec. 4.1; zero-to-peak is assumed)."""


class Piezo(Block):
    """Piezoelectric patches, each half a wavelength long and centred on an antinode."""

    patches: Annotated[Whole, Field(ge=1)] = 4
    """Number of patches (paper, Sec. 4.1)."""
    e31_n_per_vm: Positive = 15.0
    """Transverse coefficient e31 in N/(V m), magnitude (assumed: a soft PZT)."""
    patch_width_mm: Positive = 14.0
    """Extent along the nodal lines (assumed)."""
    patch_thickness_mm: Positive = 0.5
    """Thickness (assumed)."""


class FingerLoad(Block):
    """What the vibration feels of a finger."""

    resistance_n_s_per_m: NotNegative = 55.0
    """Mechanical resistance at ultrasonic frequencies in N s/m (Monnoyer et al., World Haptics 2017)."""
    contact_mm: Positive = 10.0
    """Diameter of the contact (assumed: 8 to 12 mm)."""


class Carrier(Block):
    """How the carrier is made: pulse width modulation by a timer, then a band-pass."""

    timer_hz: Positive = 36e6
    """Clock of the timer: the paper's Teensy 3.1 (forum.pjrc.com/threads/25164); 132e6 on a Teensy 4.1."""
    control_hz: Positive = 5000.0
    """Rate at which the amplitude command changes (paper, Sec. 4.1)."""
    band_low_hz: Positive = 10e3
    """Lower edge of the band-pass (paper, Sec. 4.1)."""
    band_high_hz: Positive = 50e3
    """Upper edge of the band-pass (paper, Sec. 4.1)."""
    filter_order: Annotated[Whole, Field(ge=1, le=6)] = 2
    """Order of the Butterworth prototype (assumed)."""
    alignment: Literal["centre", "edge"] = "centre"
    """Where pulses grow from: a fixed centre (both edges set by the timer) or their first edge (assumed)."""

    def _check(self) -> None:
        if not self.band_low_hz < self.band_high_hz:
            raise must_be("band_low_hz", self.band_low_hz, f"below band_high_hz = {self.band_high_hz:g}")


class PlateDesign(Description):
    """An ultrasonic plate as a builder describes it."""

    glass: Glass = Glass()
    """Material."""
    geometry: PlateGeometry = PlateGeometry()
    """Size and mode."""
    drive: PlateDrive = PlateDrive()
    """Resonance and amplitude."""
    piezo: Piezo = Piezo()
    """Actuators."""
    finger: FingerLoad = FingerLoad()
    """Load."""
    carrier: Carrier = Carrier()
    """Electronics."""
