"""Small tables of results: kept as a file that names its command, and shown between marks on the pages.

``python -m studies.kept`` writes the tables of *pages/*, and of three pages of *docs*, anew from what is kept.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.design.comparison.comparison_scores import spread
from frictionloop.quantities.code_version import package_version

HERE = Path(__file__).parent
SHOWN_IN = [
    HERE.parent / "docs" / name for name in ("validation.md", "which-law.md", "experiments.md", "calibration.md")
]
"""Pages of the documentation with tables of a study."""
RESULTS, PAGES = HERE / "results", HERE / "pages"
SHOWN = re.compile(r"<!-- results/([\w-]+)\.csv -->\n.*?<!-- end -->", re.DOTALL)
"""A table on a page: the comment before it names its file."""


def keep(name: str, command: str, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a table, row by row as it comes, below a line that says where it is from."""
    with (RESULTS / f"{name}.csv").open("w", newline="", encoding="utf-8") as stream:
        stream.write(f"# python -m studies.{command}, frictionloop {package_version()}\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(heads)
        for row in rows:
            writer.writerow(row)
            stream.flush()


def both(values: np.ndarray, digits: int = 1) -> str:
    """Return median / worst decile of what is better the smaller it is."""
    return " / ".join(f"{value:.{digits}f}" for value in spread(values, False))


def markdown(path: Path) -> str:
    """Return a kept table as Markdown."""
    with path.open(newline="", encoding="utf-8") as stream:
        heads, *rows = csv.reader(line for line in stream if not line.startswith("#"))
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [heads, ["---"] * len(heads), *rows])


def written(page: str) -> str:
    """Return a page with each of its tables as it is kept."""

    def table(found: re.Match[str]) -> str:
        name = found[1]
        return f"<!-- results/{name}.csv -->\n\n{markdown(RESULTS / f'{name}.csv')}\n\n<!-- end -->"

    return SHOWN.sub(table, page)


if __name__ == "__main__":
    for path in [*sorted(PAGES.glob("*.md")), *SHOWN_IN]:
        path.write_text(written(path.read_text(encoding="utf-8")), encoding="utf-8")
