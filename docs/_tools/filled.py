"""Numbers and tables that pages hold as text, so that they are read unbuilt too: python docs/_tools/filled.py.

``22.9<!-- n.kp_limit -->`` is a number of `facts.numbers`, and what stands between ``<!-- table_gains -->`` and
``<!-- end -->`` a table of `facts`. The command writes both anew; the build stops where they are not
what the package computes.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import facts

PAGES = (
    "paper-notes.md",
    "model.md",
    "finger.md",
    "which-law.md",
    "reliability.md",
    "how-to/reproduce-the-paper.md",
    "../README.md",
)
TABLES = facts.readings, facts.delays, facts.noise_gains, facts.sensor_faults, facts.sensor_faults_untold
NUMBER = re.compile(r"[\w.,+−%-]+<!-- n\.(\w+) -->")
TABLE = re.compile(r"<!-- table_(\w+) -->\n.*?<!-- end -->", re.DOTALL)


def filled(text: str, numbers: dict[str, str], tables: dict[str, str]) -> str:
    """Return the text of a page with the numbers and tables that are so."""
    text = NUMBER.sub(lambda found: f"{numbers[found[1]]}<!-- n.{found[1]} -->", text)
    return TABLE.sub(lambda found: f"<!-- table_{found[1]} -->\n\n{tables[found[1]]}\n\n<!-- end -->", text)


def changed(folder: Path) -> dict[Path, str]:
    """Return the pages of a folder whose numbers are not so, with what they must say."""
    numbers, tables = facts.numbers(), {make.__name__: make().strip() for make in TABLES}
    texts = {folder / name: (folder / name).read_text(encoding="utf-8") for name in PAGES}
    must = {page: filled(text, numbers, tables) for page, text in texts.items()}
    return {page: text for page, text in must.items() if text != texts[page]}


def main() -> int:
    """Write the pages that are not so."""
    for page, text in changed(Path(__file__).parents[1]).items():
        page.write_text(text, encoding="utf-8")
        print(page.name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
