"""Constants of a contact's step from the numbers of skin and contact."""

from __future__ import annotations

from frictionloop.parameters import Skin
from frictionloop.physics.bristle_contact import ContactCoefficients, contact_coefficients


def constants_of(dt, k, c, m, slip_length_um=11.5) -> ContactCoefficients:
    """Return the constants for a step in s, of k, c, m of the skin and the slip length."""
    skin = Skin(stiffness_n_m=k, damping_n_s_m=c, mass_kg=m, slip_length_um=slip_length_um)
    return contact_coefficients(skin, dt)
