"""What the springs and the mass of a fingertip hold, in J."""


def skin_energy_j(lag_m, lag_speed_m_s, stiffness_n_per_m, mass_kg):
    """(k x^2 + m x'^2)/2."""
    return (stiffness_n_per_m * lag_m**2 + mass_kg * lag_speed_m_s**2) / 2


def bristle_energy_j(bristle_m, stiffness_n_per_m):
    """s0 z^2/2."""
    return stiffness_n_per_m * bristle_m**2 / 2
