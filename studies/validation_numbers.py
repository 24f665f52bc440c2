"""The published numbers of ``python -m studies.validation``: interval, source, and the expression that computes ours.

An interval is the published one where there is one; else it is ``around`` the number, and the source says so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

ABOUT = "; ±20 %"
DERLER = (
    "[Derler, Rotaru](https://discovery.researcher.life/article/24def7cbf4333be7a1684c6b65e3309b), wet glass, abstract"
)
ELECTROVIBRATION = "per mm/s, [arXiv 2505.11162](https://arxiv.org/abs/2505.11162), ten people, abstract" + ABOUT
CONTACT_AREA = "Kenanoglu, Wiertlewski, Vardar 2026, ten people, summary" + ABOUT
PMC = "https://pmc.ncbi.nlm.nih.gov/articles"
SLIDE_AT = "https://doi.org/10.1109/TOH.2021.3130091"
SLIDE = f"[one slide]({SLIDE_AT})"


class Number(NamedTuple):
    """A published number, and what computes ours."""

    number: str
    quantity: str
    how: str
    """Expression in the names of `studies.validation`; empty where there is no bench to compute it on."""
    low: float
    high: float
    source: str
    built: str = ""
    """Parameter that was taken from the source."""


def around(published: float) -> tuple[float, float]:
    """Return a number -20 % and +20 % (assumed)."""
    return published - 0.2 * abs(published), published + 0.2 * abs(published)


NUMBERS = (
    Number(
        "1a",
        "cutoff of friction at 0.6 N, Hz per mm/s",
        "per_mm_s(lambda v: cutoff_hz(v, 0.6))",
        *around(13.8),
        f"13.8 {ELECTROVIBRATION}",
        "finger.slip_length_um",
    ),
    Number(
        "1b",
        "the same at 0.25 N",
        "per_mm_s(lambda v: cutoff_hz(v, 0.25))",
        *around(13.8),
        f"13.8 {ELECTROVIBRATION}",
        "finger.slip_length_um",
    ),
    Number(
        "2a",
        "stiffness of the skin, N/m per mm/s",
        "per_mm_s(lambda v: at(v).finger.stiffness_n_m)",
        *around(4.04),
        f"4.04 {ELECTROVIBRATION}",
    ),
    Number(
        "2b",
        "moving mass of the skin, mg per mm/s",
        "per_mm_s(lambda v: 1e6 * at(v).finger.mass_kg)",
        *around(32.3),
        f"32.3 {ELECTROVIBRATION}",
    ),
    Number("3a", "peak of the skin's response, Hz (0: none)", "skin_peak_hz()", *around(116.0), f"116, {CONTACT_AREA}"),
    Number(
        "3b",
        "where stiffness gives way to mass, Hz",
        "math.sqrt(CALM.finger.stiffness_n_m / CALM.finger.mass_kg) / math.tau",
        *around(320.0),
        f"regimes split at 320, {CONTACT_AREA}",
    ),
    Number("4a", "peak at the onset of sliding over the level after", 'onset("ratio")', 1.40, 1.52, f"1.44, {SLIDE}"),
    Number(
        "4b",
        "the same after 1.4 s of rest, static ratio 1.44",
        "rested(1.44).max() / rested(1.44)[-1]",
        1.40,
        1.52,
        f"1.44, {SLIDE}",
        "friction.static_ratio",
    ),
    Number("5", "rise at the onset, N/mm", '1e-3 * onset("stiffness_n_m")', *around(2.56), f"2.56, {SLIDE}{ABOUT}"),
    Number(
        "6",
        "spectrum's slope p without the load's part",
        'sliding("own_slope", level=True)',
        0.70,
        1.40,
        f"1.05, 95 %, {SLIDE}",
    ),
    Number("7", "friction coefficient, dry", 'sliding("coefficient")', 0.38, 0.49, f"0.43, {SLIDE}"),
    Number(
        "8a",
        "friction coefficient, moist",
        'plain()["limit"].values[-1] / MOIST.motion.load_n',
        0.43,
        1.13,
        f"0.78 ± 0.35, {DERLER}",
    ),
    Number(
        "8b",
        "friction in stick-slip at 0.2 mm/s over that of sliding, static ratio 1.44",
        "friction(0.2, 1.44).mean() / friction(20.0, 1.44).mean()",
        *around(0.7),
        f"30 % lower, {DERLER}{ABOUT}",
    ),
    Number(
        "9a",
        "half the range of the coefficient over its mean, sliding, %",
        "coefficient_range()",
        0.0,
        10.0,
        f"within ±10 %, {DERLER}",
    ),
    Number(
        "9b",
        "the same in stick-slip at 0.2 mm/s, static ratio 1.44, %",
        "half_range(friction(0.2, 1.44))",
        25.0,
        math.inf,
        f"over ±25 %, {DERLER}",
    ),
    Number(
        "10",
        "coefficient from 1 to 20 N, %",
        "100 * (coefficient(20.0) / coefficient(1.0) - 1)",
        *around(-46.0),
        f"-46, [Seo 2009](https://pubmed.ncbi.nlm.nih.gov/19431002), abstract{ABOUT}",
    ),
    Number(
        "11",
        "time of contact until 95 % of friction's rise, s",
        "saturation_s()",
        0.0,
        20.0,
        f"contact area, typically within 20, [PMC5642691]({PMC}/PMC5642691), abstract; 95 % assumed",
    ),
    Number(
        "12",
        "friction after minutes over that just landed",
        'plain()["limit"].values[-1] / plain()["limit"].values[0]',
        *around(10.0),
        f"10, [Adams 2013](https://doi.org/10.1098/rsif.2012.0467), abstract{ABOUT}",
    ),
    Number(
        "13",
        "friction left at full vibration, just landed, %",
        '100 * plain()["floor"].values[0] / plain()["limit"].values[0]',
        *around(5.0),
        f"up to 95 % less, press on [PNAS 2016](https://hal.science/hal-01454771){ABOUT}",
    ),
    Number(
        "14",
        "friction left at full vibration, moist over dry",
        '(plain()["floor"] / plain()["limit"]).values[-1] / (plain()["floor"] / plain()["limit"]).values[0]',
        1.0,
        math.inf,
        "less reduction, [Gueorguiev 2017](https://ouci.dntb.gov.ua/en/works/9jZNnDV9), abstract",
        "friction.moist_loss",
    ),
    Number(
        "15",
        "resistance of a finger in `design plate`, N s/m",
        "PlateDesign().finger.resistance_n_s_per_m",
        *around(55.0),
        f"55, [Monnoyer 2017](https://hal.science/hal-01587277), abstract{ABOUT}",
        "finger.resistance_n_s_per_m",
    ),
    Number(
        "16",
        "time until 95 % of friction's fall, ms",
        "fall_ms()",
        *around(20.0),
        f"strain of a pressed finger let go in 20, [PMC9905974]({PMC}/PMC9905974), abstract{ABOUT}",
    ),
    Number(
        "17",
        "corner of the skin, Hz",
        "CALM.finger.stiffness_n_m / CALM.finger.damping_n_s_m / math.tau",
        *around(100.0),
        f"100, [Willemet](https://github.com/lwillemet/Finger_skin_filtering){ABOUT}",
    ),
    Number(
        "18",
        "time until 95 % of an amplitude, ms",
        "1e3 * math.log(20) * time_constant_s(CALM.plate.frequency_hz, CALM.plate.q)",
        2.5,
        10.0,
        "closed loops: 2.5, [Giraud 2013](https://inria.hal.science/hal-00924620v1); 10, "
        "[Ghenna 2017](http://hdl.handle.net/10985/16156); 95 % assumed",
    ),
    Number(
        "19",
        "peak felt of a rise over that of a fall",
        "felt(after(2.5, 0.0)) / felt(after(0.0, 2.5))",
        1.0,
        math.inf,
        "rise felt stronger, [Saleem 2018](https://pubmed.ncbi.nlm.nih.gov/29994033), abstract",
    ),
    Number(
        "20",
        "Weber fraction of friction",
        "Observer().weber",
        *around(0.11),
        f"0.11, [Gueorguiev 2017](https://ouci.dntb.gov.ua/en/works/9jZNnDV9), abstract{ABOUT}",
        "observer.weber",
    ),
    Number(
        "21",
        "textures told apart, played back against real ones",
        "",
        0.0,
        0.0,
        f"71 to 72 % against 95 % on electroadhesion, [Grigorii 2021]({SLIDE_AT}); not on ultrasound",
    ),
    Number(
        "22",
        "crossover of closed-loop friction",
        "",
        0.0,
        0.0,
        "1.21 kHz on [electroadhesion](https://github.com/romangrigorii/closed_loop_application_of_electroadhesion); "
        "not on ultrasound",
    ),
    Number(
        "23",
        "share of 5, 15, 30, 45 mm/s with friction that varies over ±1 %",
        "np.mean([half_range(friction(v)) > 1 for v in (5.0, 15.0, 30.0, 45.0)])",
        0.25,
        1.0,
        "instabilities there, mock finger, [eLife 104543](https://elifesciences.org/reviewed-preprints/104543)",
    ),
)
