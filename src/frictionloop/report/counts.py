"""What comes out, counted and told: the first things that the page says of the claims."""

from __future__ import annotations

from collections.abc import Sequence

from frictionloop.report.claims import COUNTED, THESIS, Claim, Group, Verdict

FIRST = ("open-loop-r2", "closed-loop-r2", "open-loop-variation", "steady-20-mn")
"""Claims of Fig. 5a that stand beside the paper's values at the top."""
EXAMPLES = ("kp-1-unsatisfactory", "kp-40-saturated", "closed-loop-r2")
"""Of what comes out."""
HOLDS = {
    Verdict.COMES_OUT: "holds",
    Verdict.ASSUMED: "holds in part",
    Verdict.CONTRADICTED: "does not hold",
}
"""What is said of the paper's thesis."""


def counts(claims: Sequence[Claim]) -> dict[str, int]:
    """Return how many claims each group has, and how those of the device are judged."""
    found = {group.name.lower(): sum(claim.group is group for claim in claims) for group in Group}
    device = [claim.verdict for claim in claims if claim.group is Group.DEVICE]
    return found | {
        "text": found["printed"] + found["assumed"] + found["contradicted"],
        "counted": sum(claim.group in COUNTED for claim in claims),
        "device out": device.count(Verdict.COMES_OUT),
        "device part": device.count(Verdict.ASSUMED),
        "device not": device.count(Verdict.CONTRADICTED),
    }


def summary(claims: Sequence[Claim]) -> list[str]:
    """Return what a terminal is told at the end."""
    n, thesis = counts(claims), next(claim for claim in claims if claim.id == THESIS)
    return [
        "",
        f"The paper's idea {HOLDS[thesis.verdict]}: the PI divides the error of the force by {thesis.ours:.3g}.",
        f"{n['printed']} of {n['text']} statements about the simulation come out as printed, "
        f"{n['assumed']} under an assumption, {n['contradicted']} do not.",
        f"Of {n['device']} about the device {n['device out']} come out on the assumed bench, "
        f"{n['device part']} under a further assumption.",
        "",
    ]


def named(claims: Sequence[Claim]) -> dict[str, str]:
    """Return the titles that the sentences about what comes out, and what does not, name."""
    out = [claim for claim in claims if claim.id in EXAMPLES and claim.verdict is Verdict.COMES_OUT]
    not_out = [claim for claim in claims if claim.verdict is Verdict.CONTRADICTED]
    return {"printed": _titles(out), "contradicted": _titles(not_out)}


def _titles(claims: Sequence[Claim]) -> str:
    return ", ".join(f"“{claim.title}”" for claim in claims)
