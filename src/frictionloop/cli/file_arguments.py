"""Values and files that only the command line takes: checked before any work is done, written after it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import frictionloop as fl
from frictionloop import FrictionloopError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOADS = "the least and the largest in N, such as 0.4,1.2, or one"
COEFFICIENTS = "the least and the largest, such as 0.4,1.2, or one"
RUN_FILES, FIGURES, TABLES, SYSTEMS = (".h5", ".hdf5", ".nc"), (".svg", ".pdf", ".png"), (".csv",), (".toml",)

OTHERS = (".csv", ".tsv", ".txt", ".mat", ".xlsx", ".parquet", ".json", ".npz")
"""Endings of what other programs read."""
ELSEWHERE = 'for other programs fl.save(fl.load("run.h5"), "run.csv"): docs/how-to/read-the-results-elsewhere.md'


def check_output(name: str, path: Path | None, accepted: tuple[str, ...], new: bool = False) -> None:
    """Refuse an output that has no folder, whose name does not end like what will be in it, or that must be ``new``."""
    if path is None:
        return
    if path.suffix not in accepted:
        other = f"; {ELSEWHERE}" if accepted is RUN_FILES and path.suffix.lower() in OTHERS else ""
        raise FrictionloopError(f"{_flag(name)} = {str(path)!r}: must end in {' or '.join(accepted)}{other}")
    if not path.parent.is_dir():
        raise FrictionloopError(f"{_flag(name)} = {str(path)!r}: there is no folder {str(path.parent)!r}")
    _check_writable(name, path, path.parent)
    if accepted is FIGURES:
        check_drawing()
    if new:
        check_new(name, path)


def check_run(out: Path | None, plot: Path | None) -> None:
    """Refuse what could not be written of a run, and its figure."""
    check_output("out", out, RUN_FILES)
    check_output("plot", plot, FIGURES)


def _flag(name: str) -> str:
    """Return what gives a file on the command line: a flag, but for the file itself."""
    return name if name == "file" else f"--{name.replace('_', '-')}"


def check_drawing() -> None:
    """Refuse to draw without what draws."""
    fl.outputs.needed("matplotlib", "matplotlib", "report")


def check_new(name: str, path: Path | None) -> None:
    """Refuse to replace a file that a person may have edited."""
    if path is not None and path.exists():
        raise FrictionloopError(f"{_flag(name)} = {str(path)!r}: exists; delete it first")


def check_folder(name: str, path: Path | None) -> None:
    """Refuse a folder for figures that is a file, or that has no folder to be made in."""
    if path is not None and not path.is_dir() and (path.exists() or not path.parent.is_dir()):
        raise FrictionloopError(f"{_flag(name)} = {str(path)!r}: must be a folder, or new in one")
    if path is not None:
        _check_writable(name, path, path if path.is_dir() else path.parent)
        check_drawing()


def _check_writable(name: str, path: Path, folder: Path) -> None:
    why = fl.outputs.why_unwritable(folder)
    if why:
        raise FrictionloopError(f"{_flag(name)} = {str(path)!r}: nothing can be written in {str(folder)!r} ({why})")


def check_count(name: str, value: int, least: int, most: int = 2**63 - 1) -> None:
    """Refuse a whole number outside its range."""
    if not least <= value <= most:
        raise FrictionloopError(f"{name} = {value}: must be a whole number from {least} to {most}")


def numbers_of(name: str, text: str, what: str) -> tuple[float, ...]:
    """Return numbers written with commas between them; ``what`` says what they are."""
    try:
        return tuple(float(each) for each in text.split(","))
    except ValueError:
        raise fl.outputs.must_be(name, text, what) from None


def two_values(name: str, text: str | None, what: str, zero: bool = False) -> tuple[float, float] | tuple[()]:
    """Return the ends of a range, one value twice, nothing if none is asked for; ``what`` says what they are.

    With ``zero`` they may be 0.
    """
    if text is None:
        return ()
    try:
        low, *ends = (float(each) for each in text.split(","))
        (high,) = ends or [low]
    except ValueError:
        low, high = math.nan, math.nan
    if not (0.0 < low <= high < math.inf or (zero and 0.0 == low <= high < math.inf)):
        raise FrictionloopError(f"{name} = {text!r}: must be {what}")
    return low, high


def check_workers(jobs: int | None, resume: bool, out: Path | None, what: str) -> None:
    """Refuse a number of workers out of range, and to go on with a file that is not named."""
    check_count("jobs", 1 if jobs is None else jobs, 1, 1024)
    if resume and out is None:
        raise FrictionloopError(f"resume: needs --out FILE.h5, the file of the {what} to continue")


def check_fingers(count: int | None, seed: int | None, most: int, **more: Any) -> None:
    """Refuse a number or a seed of fingers out of range, and what says where fingers come from without any."""
    for name, given in more.items():
        if given is not None and not count:
            raise FrictionloopError(f"{name}: accepted with --fingers N")
    if count is None:
        if seed is not None:
            raise FrictionloopError(f"fingers_seed = {seed}: accepted with --fingers N")
        return
    check_count("fingers", count, 1, most)
    check_count("fingers_seed", seed or 0, 0)


def check_score(score_from_s: float, duration_s: float) -> None:
    """Refuse a scored part that is empty."""
    # A wrong duration is complained about where it is used.
    if not 0 <= score_from_s < math.inf or 0 < duration_s <= score_from_s:
        raise FrictionloopError(
            f"score_from_s = {score_from_s:g} s: must be from 0 s to less than duration_s = {duration_s:g} s"
        )


def write_figures(option: str, folder: Path, figures: Mapping[str, Figure]) -> None:
    """Write figures by name, as SVG and as PNG, into a folder that is made if need be; errors name the option."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{option} = {str(folder)!r}: cannot be created ({error.strerror})") from None
    for name, figure in figures.items():
        fl.figures.write_both(figure, name, folder / f"{name}.svg")


def write_figure(path: Path, figure: Figure) -> None:
    """Write one figure, in the form that its name ends with."""
    with fl.outputs.replacing(path) as beside:
        figure.savefig(beside, format=path.suffix[1:])


def write_csv(path: Path, table: Any) -> None:
    """Write rows, or a DataFrame, as a table."""
    import pandas  # type: ignore[import-untyped]

    with fl.outputs.replacing(path) as beside:
        pandas.DataFrame(table).to_csv(beside, index=False)
