"""A system and a run in words: one row per block under the names that flags use, one row per metric."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

Row = tuple[str, ...]


def system_rows(system: System) -> list[Row]:
    """Return (block, its kind and values) for each block, nested blocks after the one that holds them."""
    rows: list[Row] = []
    for name, block in system.model_dump().items():
        rows += _block_rows(name, block)
    return rows


def _block_rows(name: str, block: dict[str, Any]) -> list[Row]:
    kind = [f"{block['kind']}:"] if "kind" in block else []
    values = [
        f"{key}={short(value)}"
        for key, value in block.items()
        if key != "kind" and value is not None and not isinstance(value, dict)
    ]
    inner = [
        row for key, value in block.items() if isinstance(value, dict) for row in _block_rows(f"{name}.{key}", value)
    ]
    return [(name, " ".join([*kind, ", ".join(values)])), *inner]


def short(value: Any) -> str:
    """Return a value with at most six digits, a long list by its first values."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        shown = ", ".join(map(short, value[:6]))
        return f"[{shown}]" if len(value) <= 6 else f"[{shown}, ... {len(value)} values]"
    return str(value)


def metrics_of(run: xr.Dataset, score_from_s: float = 0.0) -> dict[str, float]:
    """Return every metric of a run by name; ``slope`` and ``intercept`` belong to r2_regression."""
    import frictionloop as fl

    mask = run["time"].values >= score_from_s
    line = fl.regression(run, mask)
    return {
        "r2_identity": fl.r2_identity(run, mask),
        "r2_bound": fl.r2_bound(run, mask),
        "r2_regression": line.r2,
        "slope": line.slope,
        "intercept": line.intercept_n,
        "rms_error": fl.rms_error(run, mask),
        "output_noise": fl.output_noise(run, mask),
        "saturation_index": fl.saturation_index(run, mask),
    }


UNITS = {"intercept": "N", "rms_error": "N", "output_noise": "N"}
"""Units of the metrics that have one; the others are pure numbers."""


def metric_rows(found: dict[str, float]) -> list[Row]:
    """Return (metric, value with unit, what it says)."""
    missing = found["r2_bound"] - found["r2_identity"]
    offset = f"{'-' if found['intercept'] < 0 else '+'} {number(abs(found['intercept']))}"
    return [
        ("r2_identity", number(found["r2_identity"]), "how well f_a follows f_r; 1 is perfect"),
        (
            "r2_bound",
            number(found["r2_bound"]),
            "the most any controller could reach" + ("" if math.isnan(missing) else f", {missing:.4f} more"),
        ),
        (
            "r2_regression",
            number(found["r2_regression"]),
            f"of the line f_a = {number(found['slope'])} f_r {offset} N",
        ),
        ("rms_error", f"{found['rms_error'] * 1e3:.4g} mN", "rms of f_a - f_r"),
        ("saturation_index", f"{found['saturation_index']:.4g}", "share of the commands that were clamped"),
    ]


def number(value: float) -> str:
    """Return a metric to four decimals, or a dash where it has no meaning (a constant set-point has no R2)."""
    return "-" if math.isnan(value) else f"{value:.4f}" if abs(value) < 100 else f"{value:.4g}"
