"""The notebooks of examples/notebooks, run anew: python docs/_tools/notebooks.py; the build of the pages runs them too.

A notebook that fails stops the build. The command writes what they print and draw into them, and nothing that changes
from run to run: no times, no counts.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[2] / "examples/notebooks"
LONGEST_S = 600


def executed(path: Path) -> Any:
    """Return a notebook with the outputs of its cells, run from the first to the last in a kernel of its own."""
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(notebook, timeout=LONGEST_S, resources={"metadata": {"path": folder}})
        client.execute()
    for number, cell in enumerate(each for each in notebook.cells if each.cell_type == "code"):
        cell.execution_count = number + 1
        cell.metadata.pop("execution", None)
        cell.outputs = [each for each in cell.outputs if each.get("name") != "stderr"]
        for each in cell.outputs:
            if "execution_count" in each:
                each["execution_count"] = number + 1
    notebook.metadata = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    return notebook


def setup(app: Any) -> dict[str, bool]:
    """Run every notebook when the pages begin to be built."""
    app.connect("builder-inited", lambda _: [executed(path) for path in sorted(FOLDER.glob("*.ipynb"))])
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    for each in sorted(FOLDER.glob("*.ipynb")):
        nbformat.write(executed(each), each)
        print(each.name)
