"""Write docs/_static/device-transcript.txt: a session at the simulated board, as a terminal shows it.

Run from the root of the repository: python docs/_tools/transcript.py. A test compares the file with what comes out.
Simulated time passes as fast as it is computed, and all noise has a seed: every machine prints the same.
"""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from textwrap import wrap

from page import command

TARGET = Path(__file__).parents[1] / "_static" / "device-transcript.txt"
WIDTH = 86
"""Characters of a line that fits the page, less those that say that it goes on."""
GLUE = "\xa0"
"""Where a line is not broken."""
SESSION = (
    ("device info sim:", 0),
    ("device set sim: drive.ceiling_um=2 setpoint.hold_n=0.5", 0),
    ("device set sim: drive.ceiling_um=9", 2),
    ("device monitor sim: --duration-s 0.3 --rate-hz 20", 0),
    ("device run sim: --controller.kp 0 --controller.ki 111 --duration-s 2 --out run.h5", 0),
    ("device run sim: --motion.load_n 4 --open --duration-s 2 --out cut.h5", 2),
    ("firmware export --preset bench --controller.kp 0 --controller.ki 111 --out my-table", 0),
)
"""Commands with the exit code each must end with."""


def transcript() -> str:
    """Return the session: commands, and what each prints."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        return "\n".join(f"{_typed(words)}\n{_shown(command(words, ends=ends))}" for words, ends in SESSION)


def _shown(text: str) -> str:
    """Return what a command prints, long lines broken as a terminal breaks them."""
    lines = [wrap(line, WIDTH + 2) if len(line) > WIDTH + 2 else [line] for line in text.split("\n")]
    return "\n".join(part for parts in lines for part in parts)


def _typed(words: str) -> str:
    """Return a command as one types it, an option with its value on a line where it is long."""
    glued = f"$ frictionloop {words}".replace(" ", GLUE).replace(f"{GLUE}--", " --")
    return " \\\n".join(wrap(glued, WIDTH, subsequent_indent="    ", break_on_hyphens=False)).replace(GLUE, " ")


if __name__ == "__main__":
    TARGET.write_text(transcript(), encoding="utf-8")
    print(TARGET)
