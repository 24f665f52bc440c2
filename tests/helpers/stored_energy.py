"""What the spring and the mass of a fingertip and its contact hold, in J."""


def skin_energy_j(lag_m, lag_speed_m_s, stiffness_n_per_m, mass_kg):
    """(k x^2 + m x'^2)/2."""
    return (stiffness_n_per_m * lag_m**2 + mass_kg * lag_speed_m_s**2) / 2


def bristle_energy_j(force_n, limit_n, length_m):
    """z F^2/(2 Fc)."""
    return length_m * force_n**2 / (2 * limit_n) if length_m else 0.0
