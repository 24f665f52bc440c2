"""The figure of a sweep: curves over one parameter, maps over two or three, a distribution over listed points."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.figures.style import BLUE, GREY, VERMILLION, new_figure, styled
from frictionloop.loop.companion_runs import OPEN_ERROR
from frictionloop.quantities import FrictionloopError, unit_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PANELS = 24
ABREAST = 2
"""Metrics in a row: more are too small to read on a page."""
LOWEST_R2 = -1.0
"""R2 below which fingers are counted and not drawn: all such are far off (chosen)."""
ABLE = {"served": " in ordinary use", "capable": ""}
"""Coordinates that say which fingers are able, the first of them that is there, and what its caption adds."""
SHOWN = {"N": (1e3, "mN"), "s": (1e3, "ms")}
"""How a metric's unit is drawn."""


@styled
def figure_of(result: xr.Dataset) -> Figure:
    """Return the figure of every metric of a sweep that has a value; what is not yet run is left white."""
    axes = [str(dim) for dim in result.dims if dim != "seed"]
    every = [str(name) for name, values in result.data_vars.items() if set(values.dims) == {*axes, "seed"}]
    names = [name for name in every if np.any(np.isfinite(result[name].values))] or every
    if len(axes) > 3:
        raise FrictionloopError(
            f'result has {len(axes)} parameters, {", ".join(axes)}: at most 3; result.sel({{"{axes[-1]}": ...}})'
        )
    if axes == ["point"]:
        return _panels(names, [None], lambda panel, name, _: _distribution(panel, result[name]))
    if axes == ["finger"]:
        return _of_fingers(result, names, [name for name in every if name not in names])
    words = [each for each in axes if result[each].dtype.kind not in "iufb"]
    if len(axes) == 1:
        return _panels(names, [None], lambda panel, name, _: _curve(panel, result[name], axes[0]))
    if set(words) & set(axes[:2]):
        raise FrictionloopError(f"{words[0]}: words go third")
    third = result[axes[2]].values.tolist() if len(axes) == 3 else [None]
    if len(third) * len(names) > MOST_PANELS:
        raise FrictionloopError(
            f"{len(third)} values of {axes[2]} and {len(names)} metrics: at most {MOST_PANELS} maps"
        )

    def drawn(panel: Axes, name: str, value: Any) -> None:
        values = result[name] if value is None else result[name].sel({axes[2]: value})
        mean = _scaled(result[name].transpose(..., "seed"))[0].mean(axis=-1)
        ends = (float(np.nanmin(mean)), float(np.nanmax(mean))) if np.isfinite(mean).any() else (0.0, 1.0)
        _map(panel, values, axes, "" if value is None else f"{axes[2]} = {_short(value)}", ends)

    return _panels(names, third, drawn)


def _panels(names: list[str], third: list[Any], draw: Any) -> Figure:
    """Return a figure of a row per metric and a column per value, or of metrics two in a row."""
    abreast = min(len(names), ABREAST)
    rows, columns = (len(names), len(third)) if len(third) > 1 else (math.ceil(len(names) / abreast), abreast)
    figure = new_figure(3.6 * columns, 3.0 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    drawn = [(name, value) for name in names for value in third]
    for panel, (name, value) in zip(panels, drawn, strict=False):
        draw(panel, name, value)
    for panel in panels[len(drawn) :]:
        panel.set_visible(False)
    return figure


def _curve(panel: Axes, metric: xr.DataArray, axis: str) -> None:
    values, label = _scaled(metric.transpose(axis, "seed"))
    at = metric[axis].values
    if at.dtype.kind not in "iufb":
        panel.plot([str(each) for each in at], np.nanmean(values, axis=1), "o", color=BLUE)
    else:
        panel.fill_between(at, np.nanmin(values, axis=1), np.nanmax(values, axis=1), color="#d5e6f2", linewidth=0)
        panel.plot(at, np.nanmean(values, axis=1), ".-", color=BLUE)
        panel.set_xscale("log" if _is_geometric(at) else "linear")
    panel.set(xlabel=_named(axis), ylabel=label)


def _map(panel: Axes, metric: xr.DataArray, axes: list[str], title: str, ends: tuple[float, float]) -> None:
    values, label = _scaled(metric.transpose(axes[1], axes[0], "seed"))
    mean = values.mean(axis=-1)
    x, y = metric[axes[0]].values, metric[axes[1]].values
    drawn = panel.pcolormesh(x, y, np.ma.masked_invalid(mean), shading="nearest", vmin=ends[0], vmax=ends[1])
    panel.figure.colorbar(drawn, ax=panel, label=label)
    panel.set(xlabel=_named(axes[0]), ylabel=_named(axes[1]), title=title)
    panel.set_xscale("log" if _is_geometric(x) else "linear")
    panel.set_yscale("log" if _is_geometric(y) else "linear")
    panel.grid(visible=False)


def _distribution(panel: Axes, metric: xr.DataArray) -> None:
    values, label = _scaled(metric.transpose("point", "seed"))
    mean = np.sort(values.mean(axis=1)[~np.isnan(values.mean(axis=1))])
    panel.step(mean, np.arange(1, mean.size + 1) / max(mean.size, 1), where="post", color=BLUE)
    for share, color in ((0.5, GREY), (0.9, VERMILLION)):
        if mean.size:
            at = float(np.quantile(mean, share))
            panel.axvline(at, color=color, linewidth=0.9, linestyle="--", label=f"{share:.0%} below {at:.3g}")
    panel.set(xlabel=label, ylabel="share of points", ylim=(0, 1.02))
    panel.legend(loc="best")


def _of_fingers(result: xr.Dataset, names: list[str], without: list[str]) -> Figure:
    """Return a panel per metric in which each finger is a point, sorted by the metric, and a caption."""
    of = next((name for name in ABLE if name in result.coords), None)
    able = None if of is None else result[of].values

    def drawn(panel: Axes, name: str, _: Any) -> None:
        if name == "rms_error" and OPEN_ERROR in names:  # as large as fingers differ: only ratios show both
            panel.set_yscale("log")
            opened, _ = _scaled(result[OPEN_ERROR].mean("seed"))
            opened = np.sort(opened[~np.isnan(opened)])
            panel.plot(
                np.arange(1, opened.size + 1), opened, color=GREY, label=f"open loop, median {np.median(opened):.3g}"
            )
        _sorted(panel, result[name], able)

    figure = _panels([name for name in names if name != OPEN_ERROR or "rms_error" not in names], [None], drawn)
    said = "Each point is one finger"
    said += "; bar: range over seeds." if result.sizes["seed"] > 1 else "."
    if able is not None and of is not None:
        hollow = f"Hollow: {int(np.sum(~able))} of {able.size} fingers, which"
        said = f"{said}\n{hollow} cannot be given the set-point{ABLE[of]}."
    if without:
        said = f"{said}\nNo value: {', '.join(without)}."
    figure.supxlabel(said, fontsize=8.0)
    return figure


def _sorted(panel: Axes, metric: xr.DataArray, able: np.ndarray | None) -> None:
    values, label = _scaled(metric.transpose("finger", "seed"))
    known = ~np.isnan(values).any(axis=1)
    order = np.flatnonzero(known)[np.argsort(values[known].mean(axis=1), kind="stable")]
    mean, rank = values[order].mean(axis=1), np.arange(1, order.size + 1)
    filled = np.ones(order.size, bool) if able is None else able[order]
    panel.vlines(rank, values[order].min(axis=1), values[order].max(axis=1), color=BLUE, linewidth=0.8)
    panel.plot(rank[filled], mean[filled], "o", color=BLUE, markersize=3.5)
    panel.plot(rank[~filled], mean[~filled], "o", color=VERMILLION, markersize=3.5, markerfacecolor="white")
    if mean.size:
        middle = float(np.median(mean))
        panel.axhline(middle, color=GREY, linewidth=0.9, linestyle="--", label=f"median {middle:.3g}")
        panel.legend(loc="best")
    panel.set(xlabel="fingers, sorted by this value", ylabel=label)
    low = int(np.sum(mean < LOWEST_R2))
    if str(metric.name).startswith("r2_") and 0 < low < mean.size / 2:  # what few have hides the rest
        panel.set_ylim(LOWEST_R2, 1.05)
        panel.set_xlabel(f"fingers, sorted; {low} below {LOWEST_R2:g}")


def _scaled(metric: xr.DataArray) -> tuple[np.ndarray, str]:
    """Return the values as they are drawn, and the metric's name with that unit."""
    units = metric.attrs.get("units", "1")
    factor, unit = SHOWN.get(units, (1.0, units))
    return factor * metric.values, f"{metric.name}" + (f" ({unit})" if unit != "1" else "")


def _named(path: str) -> str:
    return f"{path} ({unit_of(path)})" if unit_of(path) else path


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _is_geometric(values: np.ndarray) -> bool:
    """Return whether values are in equal ratios, over a factor of at least 4."""
    if values.size < 3 or values.min() <= 0 or values.max() < 4 * values.min():
        return False
    ratios = np.diff(np.log(values))
    return bool(np.allclose(ratios, ratios[0], rtol=1e-6))
