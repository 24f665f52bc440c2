"""The documentation: what its code blocks do when run, and that it leaves nothing out."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import pytest
from kinds import kinds_of

import frictionloop as fl
from frictionloop.loop.registered_blocks import forget
from frictionloop.parameters.block import Block
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.parameters.refusals import known_names
from frictionloop.parameters.sensor_design import SensorDesign

DOCS = Path(__file__).parents[2] / "docs"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
WIDEST = 88
"""Characters of a line of code that the pages show without scrolling."""
BENCH = ("will-it-ring", "controllers", "plate", "force-sensor", "findings", "finger", "perception", "effects")
PAGES = [
    DOCS / "start.md",
    DOCS / "tutorial.md",
    *(DOCS / f"{name}.md" for name in BENCH),
    *sorted((DOCS / "how-to").glob("*.md")),
]


@pytest.fixture
def tools(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_tools"))
    yield
    forget()
    for name in [name for name, module in sys.modules.items() if str(DOCS) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]


def blocks(page):
    return FENCE.findall(page.read_text(encoding="utf-8"))


def test_building_the_documentation_runs_the_blocks_of_every_page():
    listed = re.search(r"^executed_pages = (\[.*?\])$", (DOCS / "conf.py").read_text(encoding="utf-8"), re.M | re.S)[1]
    patterns = ast.literal_eval(listed)
    for page in PAGES:
        assert any(language == "python" for language, _ in blocks(page)), page
        name = page.relative_to(DOCS).with_suffix("").as_posix()
        assert any(fnmatch(name, each) for each in patterns), name


@pytest.mark.usefixtures("tools")
def test_a_block_shows_what_it_prints_and_draws_and_what_is_refused(tmp_path):
    from page import Page

    page = Page(tmp_path)
    page.run("python", "import frictionloop as fl\nimport matplotlib.pyplot as plt")
    text, figures = page.run("python", "print(1)\nplt.plot([1, 2])\nplt.show()")
    assert text == "1\n"
    assert len(figures) == 1
    assert len(page.run("python", "figure = fl.plot(fl.simulate(fl.paper(), 0.1))")[1]) == 1
    assert page.run("python", "print(figure)")[1] == []
    assert page.run("python", "fl.preset('papre')  # refused")[0].startswith("FrictionloopError: preset")
    with pytest.raises(fl.FrictionloopError):
        page.run("python", "fl.preset('papre')")
    with pytest.raises(AssertionError, match="nothing was refused"):
        page.run("python", "fl.preset('paper')  # refused")
    page.run("toml", '# mine.toml\nschema = 1\npreset = "paper"\n')
    block = "$ frictionloop simulate mine.toml \\\n    --duration-s 0.1 | head -n 1\n"
    assert page.run("console", block)[0].splitlines()[2:] == ["pi       kp 10   ki 2 1/s"]
    assert "R2 " in page.run("console", "$ frictionloop simulate mine.toml --duration-s 0.1")[0]
    with pytest.raises(RuntimeError, match="exit code 2"):
        page.run("console", "$ frictionloop simulate yours.toml")


def test_code_fits_the_page():
    texts = [(path.stem, text) for path in [*PAGES, DOCS / "index.md"] for _, text in blocks(path)]
    assert [(name, line) for name, text in texts for line in text.splitlines() if len(line) > WIDEST] == []


def inner(kind):
    """Blocks that a block holds."""
    found = [field.annotation for field in kind.model_fields.values()]
    return [block for block in found if isinstance(block, type) and issubclass(block, Block)]


@pytest.mark.parametrize("design", [PlateDesign, SensorDesign])
@pytest.mark.usefixtures("tools")
def test_the_table_of_a_design_has_every_value(design):
    from tables import design as table_of

    table = table_of(design)
    assert [path for path in known_names(design, design().model_dump()) if f"| `{path}` |" not in table] == []


@pytest.mark.usefixtures("tools")
def test_the_table_of_presets_has_every_value_that_one_has():
    from tables import presets

    rows = {line.split(" | ")[0].strip("| `"): line.split(" | ") for line in presets().splitlines()}
    assert rows["controller.kp"][1:4] == ["10", "10", "10"]
    assert rows["sensor.resonance_hz"][1:4] == ["", "", "145"]
    assert set(known_names(fl.System, fl.bench().model_dump())) <= set(rows)


@pytest.mark.usefixtures("tools")
def test_the_parameters_page_has_every_block_and_field():
    from tables import BLOCKS, VALUELESS, parameters

    page = (DOCS / "parameters.md").read_text(encoding="utf-8")
    kinds = {kind for block in fl.System.model_fields for kind in kinds_of(block)}
    blocks = {block for kind in kinds for block in [kind, *inner(kind)]} - {fl.Touch}
    assert blocks == {*BLOCKS.values(), *VALUELESS}
    for name, block in BLOCKS.items():
        assert f"{{{{ parameters_{name} }}}}" in page
        table = parameters(block)
        for field, about in block.model_fields.items():
            if field not in ("kind", "model"):
                assert f"| `{field}` |" in table
                assert about.description


def reference():
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted((DOCS / "reference").glob("*.md")))


def test_the_reference_has_every_public_name():
    page = reference()
    assert [name for name in dir(fl) if not re.search(rf":: (\S*\.)?{name}$", page, re.MULTILINE)] == []


def names_of(room):
    """Names of a room: what its ``__init__`` imports, or imports when first used."""
    module = importlib.import_module(f"frictionloop.{room}")
    if hasattr(module, "HOMES"):
        return list(module.__all__)
    found = vars(module)
    return [name for name, each in found.items() if not name.startswith("_") and not inspect.ismodule(each)]


@pytest.mark.parametrize("room", ["analysis", "design"])
def test_the_reference_has_every_name_of_the_analysis(room):
    page = reference()
    names = names_of(room)
    assert [name for name in names if not re.search(rf":: (\S*\.)?{name}$", page, re.MULTILINE)] == []


@pytest.mark.parametrize("room", ["perception", "identification", "identification.rigs"])
def test_the_reference_has_every_name_of_the_room(room):
    page = reference()
    listed = page.split(f".. currentmodule:: frictionloop.{room}\n")[1].split("currentmodule")[0]
    names = names_of(room)
    assert [name for name in names if not re.search(rf":: {name}$", listed, re.MULTILINE)] == []


def test_the_contents_have_every_page():
    listed = re.findall(r"^[\w/-]+$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    pages = {
        path.relative_to(DOCS).with_suffix("").as_posix() for path in [*DOCS.glob("*.md"), *DOCS.glob("how-to/*.md")]
    }
    assert pages - {"index"} <= set(listed)


@pytest.mark.usefixtures("tools")
def test_the_numbers_of_the_notes_are_all_used():
    from facts import numbers
    from filled import PAGES as FILLED

    pages = "".join((DOCS / name).read_text(encoding="utf-8") for name in FILLED)
    assert set(re.findall(r"<!-- n\.(\w+) -->", pages)) == set(numbers())


LOOKED_UP = {"parameters", "command-line", "protocol", "reference"}
"""Pages that are looked things up in, not read."""


PROSE = [*sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("how-to/*.md")), DOCS.parent / "README.md"]


def test_no_page_is_too_long_to_read():
    """Some 2,500 words with their figures, outputs and computed tables are 8,000 pixels at a width of 1280."""
    for page in (page for page in PROSE if page.stem not in LOOKED_UP):
        text = page.read_text(encoding="utf-8")
        assert len(re.sub(r"<!-- table_\w+ -->.*?<!-- end -->", "", text, flags=re.DOTALL).split()) < 2500, page


NOTES = {"paper-notes"}
HISTORY = re.compile(
    r"(the \w+|one) before this|\bno longer\b(?! matters)|\bany ?more\b|\bformerly\b|\buntil now\b|\bat first it\b"
    r"|this project started|earlier (version|loop|schedule)|mended since|\bused to (be|have|take|leave)\b",
    re.IGNORECASE,
)
"""What tells how the project got here."""


@pytest.mark.usefixtures("tools")
def test_a_sentence_has_at_most_two_numbers_and_thirty_words():
    from sentences import crowded

    assert {path.name: found for path in PROSE if path.stem not in NOTES and (found := crowded(path))} == {}


@pytest.mark.usefixtures("tools")
def test_half_of_the_sentences_of_a_page_are_short():
    from sentences import MEDIAN, sentences

    lengths = {path.name: [each.words for each in sentences(path.read_text(encoding="utf-8"))] for path in PROSE}
    assert {name: each for name, each in lengths.items() if each and np.median(each) > MEDIAN} == {}


@pytest.mark.usefixtures("tools")
def test_numbers_of_sentences_are_counted():
    from sentences import sentences

    page = """A kp of 10 and a ki of 2 in Section 2.3, [at](https://x.org/12) $f_0 = 0.8$ N. `kp 4` has
one, 5e-5 N. A plate of 255 × 140 × 3 mm.

| 1 | 2 | 3 | 4 |

- From 20 to 80 mm/s, 4 %.

```text
1 2 3 4
```
"""
    counted = [(each.line, each.numbers, each.words) for each in sentences(page)]
    assert counted == [(1, 3, 15), (1, 1, 5), (1, 1, 7), (6, 3, 6)]


def test_pages_tell_no_history():
    pages = [*PROSE, *sorted(DOCS.glob("reference/*.md"))]
    lines = [(path.stem, *each) for path in pages for each in enumerate(path.read_text("utf-8").splitlines(), 1)]
    assert [each for each in lines if HISTORY.search(each[2])] == []


def test_links_have_a_text_and_lead_somewhere_where_pages_are_read_unbuilt():
    for path in PROSE:
        text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        for words, target in re.findall(r"\[([^\]]*)\]\((?!https?:)([^)\s]*)\)", text):
            assert words.strip() and "sphx_glr" not in target, (path, target)
            assert (path.parent / target.partition("#")[0]).exists(), (path, target)


def test_the_glossary_has_the_words_that_pages_use_in_a_sense_of_their_own_in_order():
    page = (DOCS / "glossary.md").read_text(encoding="utf-8").split("```")[1]
    words = [word for line in page.splitlines() if re.match(r"\w", line) for word in line.split(", ")]
    terms = [line for line in page.splitlines() if re.match(r"\w", line)]
    assert terms == sorted(terms, key=str.lower)
    assert {"law", "rest", "fall", "hold", "told", "row", "capable", "felt", "task", "ring"} <= set(words)


@pytest.mark.usefixtures("tools")
def test_a_page_that_is_too_high_is_found(tmp_path, capsys):
    from heights import browser, main

    if browser() is None:
        pytest.skip("no chromium here")
    for name, px in (("high", 9000), ("low", 500), ("reference", 9000)):
        (tmp_path / f"{name}.html").write_text(f'<body style="margin:0"><div style="height:{px}px"></div>')
    assert main(str(tmp_path)) == 1
    assert capsys.readouterr().out == "high.html: 9000 px, at most 8000\n"
    (tmp_path / "high.html").unlink()
    assert main(str(tmp_path)) == 0


def test_studies_stay_small():
    studies = DOCS.parent / "studies"
    files = [path for ending in ("py", "md", "csv") for path in studies.rglob(f"*.{ending}")]
    kept = [path for path in files if "runs" not in path.parts]
    assert sum(len(path.read_text(encoding="utf-8").splitlines()) for path in kept) <= 6000
