"""The numbers of the bench that pages quote: who is within reach, and what limits the loop, part by part."""

from __future__ import annotations

import frictionloop as fl
from frictionloop.analysis.limits import headroom
from frictionloop.report.claims.device_claims import capable_share
from frictionloop.report.control_law_study import NOTCH, RETUNED_GAINS, stored
from frictionloop.report.paper_protocol import SCORED_S


def numbers() -> dict[str, str]:
    """Return the single numbers."""
    bench, study = fl.bench(), stored()
    retuned = bench.evolve(fl.RETUNED)
    left, prompt = (headroom(each, 1.7) for each in (retuned, retuned.evolve({"controller.delay_s": 0.0})))
    stretched_n_s = 1e-3 * bench.motion.speed_mm_s * bench.finger.stiffness_n_m
    ringing, stable = (1e3 * fl.rms_error(fl.simulate(each)) for each in (bench, retuned))
    return {
        "capable": f"{capable_share(SCORED_S):.0%}",
        "capable_moving": f"{capable_share(SCORED_S, load_moves=True):.0%}",
        "ringing_mn": f"{ringing:.0f}",
        "stable_mn": f"{stable:.0f}",
        "rise_n_s": f"{stretched_n_s:.0f}",
        "kp_bench": f"{fl.kp_limit(bench):.2f}",
        "kp_stiff": f"{fl.kp_limit(bench.evolve({'sensor.kind': 'lowpass'})):.1f}",
        "disturbed_mn": f"{1e3 * left.disturbance_rms_n:.0f}",
        "least_mn": f"{1e3 * left.least_rms_n:.1f}",
        "least_prompt_mn": f"{1e3 * prompt.least_rms_n:.1f}",
        "pi_left_mn": f"{1e3 * study.value(RETUNED_GAINS, 30.0, 'residual_rms_n'):.0f}",
        "notch_left_mn": f"{1e3 * study.value(NOTCH, 30.0, 'residual_rms_n'):.0f}",
        "noise_mn": f"{1e3 * fl.output_noise_rms_n(retuned):.3f}",
    }
