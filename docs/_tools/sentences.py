"""Sentences with more numbers or words than a reader keeps: python docs/_tools/sentences.py [PAGE...].

Code, tables, equations, links and what is a name, not a quantity (Section 2, Fig. 5a, a year, a version) are left out.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

MOST = 2
"""Numbers in a sentence."""
LONGEST, MEDIAN = 30, 20
"""Words in any sentence of a page, and in the median one."""
ROOT = Path(__file__).parents[2]
NOT_PROSE = re.compile(
    r"^(```|~~~|:::).*?^\1\S*$|\$\$.*?\$\$(\s*\(\w+\))?|^\$ .*?$|<!--.*?-->|^- \[[A-Z]\w+\]:.*?$",
    re.MULTILINE | re.DOTALL,
)
"""Code, equations, commands, comments, and entries of a list of sources."""
CODE = re.compile(r"`[^`]*`|\]\([^)]*\)|https?://\S+|\bdoi:? ?\S+|\bISBN [\d-]+|\{[a-z]+\}|\[10\.\S+\]")
FORMULA = re.compile(r"\$([^$\n]*)\$")
VALUE = re.compile(r"(?:^|=|\\approx|\\le|\\ge|<|>)\s*(-?\d[\d.]*)")
"""What of a formula is a number that a reader is given: all of it, or what follows a sign of equality."""
NAMES = re.compile(
    r"\b(?:Sections?|Sec\.|Figs?\.|Figures?|Tables?|notes?|decisions?|steps?|row|ref\.|chapter|schema|Python|Teensy|seeds?"
    r"|[Ee]quations?|version)\s+\(?\d[\w.]*\)?(?:(?:,| to| and| or) \(?\d[\w.]*\)?)*"
    r"|\b(?:19|20)\d\d\b|\[\d+\]|\b[A-Za-z]+[-_]?\d[\w.-]*|\b\d+D\b"
)
"""Numbers that are part of a name."""
NUMBER = re.compile(r"(?<![\w.])[-+−±]?\d[\d,.  ]*(?:e-?\d+|[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)?(?:\s*[×x·±]\s*[\d.]+)*|\{\{ n\.\w+ \}\}")
BREAK = re.compile(r"(?<=[.!?])[*\"')]*\s+(?=[\"'(\[]*(?:[A-Z0-9$]|[*`]+\w))")


class Sentence(NamedTuple):
    """One of a page."""

    line: int
    text: str
    numbers: int
    words: int
    """A piece of code, a formula or a link's text between its words counts as one."""


def sentences(text: str) -> Iterator[Sentence]:
    """Yield the sentences of a page."""
    prose = NOT_PROSE.sub(lambda found: "\n" * found[0].count("\n"), text)
    block: list[str] = []
    for number, line in enumerate([*prose.splitlines(), ""], 1):
        apart = not line.strip() or re.match(r"\s*([-*] |\d+\. |#|\||>|[:!(\[]?\w*[:!]\[)", line)
        if apart and block:
            yield from _of(" ".join(block), number - len(block))
            block = []
        if line.strip() and not line.lstrip().startswith(("|", "#")):
            block.append(re.sub(r"^\s*(?:[-*] |\d+\. |: )", "", line).strip())


def _of(paragraph: str, line: int) -> Iterator[Sentence]:
    for sentence in BREAK.split(paragraph):
        prose = FORMULA.sub(lambda found: " ".join(VALUE.findall(found[1])), CODE.sub("", sentence))
        plain = NAMES.sub("", prose)
        spoken = re.sub(r"`[^`]*`", "x", FORMULA.sub("x", re.sub(r"\]\([^)]*\)", "", sentence)))
        words = sum(bool(re.search(r"\w", each)) for each in spoken.split())
        yield Sentence(line, sentence, len(NUMBER.findall(plain)), words)


def crowded(path: Path) -> list[Sentence]:
    """Return the sentences of a page with more numbers than `MOST`, or more words than `LONGEST`."""
    found = sentences(path.read_text(encoding="utf-8"))
    return [each for each in found if each.numbers > MOST or each.words > LONGEST]


def read() -> list[Path]:
    """Return the pages that readers use."""
    docs = ROOT / "docs"
    pages = [*docs.glob("*.md"), *docs.glob("how-to/*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    return sorted(path for path in pages if not path.stem.startswith("paper-notes"))


def main(names: Iterable[str]) -> None:
    """Print the offenders, the worst first."""
    found = [(path, each) for path in [Path(name) for name in names] or read() for each in crowded(path)]
    for path, each in sorted(found, key=lambda one: -one[1].numbers):
        print(f"{path.name}:{each.line}: {each.numbers} numbers, {each.words} words: {each.text}")


if __name__ == "__main__":
    main(sys.argv[1:])
