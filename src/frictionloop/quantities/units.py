"""Units carried by names, and the error every bad value raises."""

from __future__ import annotations

_UNITS = (
    ("_per_um2", "um^-2"),
    ("_kg_per_m3", "kg/m^3"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_vm", "N/(V m)"),
    ("_n_per_count", "N/count"),
    ("_m_per_count", "m/count"),
    ("_counts", "counts"),
    ("_m_s2_rthz", "m/s^2/rtHz"),
    ("_um_per_n", "um/N"),
    ("_n_rthz", "N/rtHz"),
    ("_nv_rthz", "nV/rtHz"),
    ("_fa_rthz", "fA/rtHz"),
    ("_rthz", "1/rtHz"),
    ("_mm_s", "mm/s"),
    ("_n_s_m", "N s/m"),
    ("_n_m", "N/m"),
    ("_urad", "urad"),
    ("_mohm", "Mohm"),
    ("_gpa", "GPa"),
    ("_mpa", "MPa"),
    ("_mhz", "MHz"),
    ("_mm2", "mm^2"),
    ("_deg", "deg"),
    ("_pa", "Pa"),
    ("_pf", "pF"),
    ("_nf", "nF"),
    ("_uh", "uH"),
    ("_kg", "kg"),
    ("_mm", "mm"),
    ("_ug", "1e-6 g"),
    ("_um", "um"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("_n", "N"),
    ("_m", "m"),
    ("_v", "V"),
    ("_k", "K"),
)
_UNITS_WITHOUT_SUFFIX = {"kp": "N/N", "ki": "1/s", "k1": "N^0.5/s", "k2": "N/s^2"}


class FrictionloopError(ValueError):
    """A request that cannot be met, said in one line: what was given, where, and what would be accepted."""


def unit_of(name: str) -> str:
    """Return the unit that a parameter's name carries, ``""`` for a pure number or a word.

    >>> unit_of("controller.delay_s"), unit_of("controller.ki"), unit_of("plate.kind")
    ('s', '1/s', '')
    """
    leaf = name.rsplit(".", 1)[-1]
    if leaf in _UNITS_WITHOUT_SUFFIX:
        return _UNITS_WITHOUT_SUFFIX[leaf]
    return next((unit for suffix, unit in _UNITS if leaf.endswith(suffix)), "")
