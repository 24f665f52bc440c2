"""Constants of a contact's step from the numbers of skin and bristle."""

from __future__ import annotations

from frictionloop.parameters import Skin
from frictionloop.physics.contact import ContactCoefficients, contact_coefficients


def constants_of(dt, k, c, m, s0=2e4, s1=1.4) -> ContactCoefficients:
    """Return the constants for a step in s, of k, c, m of the skin and s0, s1 of the bristle."""
    skin = Skin(stiffness_n_m=k, damping_n_s_m=c, mass_kg=m, bristle_stiffness_n_m=s0, bristle_damping_n_s_m=s1)
    return contact_coefficients(skin, dt)
