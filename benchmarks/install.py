"""What an installation takes, and where the time of the first run goes.

python benchmarks/install.py            # a fresh environment: size by package, and the first run of two presets by part
python benchmarks/install.py --write    # the same, into benchmarks/results/install.md
python benchmarks/install.py --unused   # here: what is installed for the package alone and not used by it
"""

import builtins
import os
import resource
import subprocess
import sys
import tempfile
import time
from importlib.metadata import distribution, distributions, requires
from pathlib import Path

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks/results/install.md"
MOST_MB, MOST_S, SHOWN_MB = 600, 60, 5
"""Goals of size and time; a package is told by name from some size on."""
FIRST_S = {"paper": 6, "bench": 10}
"""Goals of the first run in an empty cache, s of a processor."""
USES = (
    ("simulate", "--duration-s", "0.1", "--out", "run.h5", "--save-system", "system.toml"),
    ("sweep", "system.toml", "--over", "controller.kp=1,2", "--duration-s", "0.1"),
)


def verb(*tokens):
    """Run a command in this process."""
    from frictionloop.cli import main

    try:
        main(tokens)
    except SystemExit as end:
        assert not end.code, tokens


def unused():
    """Return what the package requires without extras, and `simulate` and `sweep` do not import."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for tokens in USES:
            verb(*tokens)
        os.chdir(ROOT)
    loaded = {os.path.realpath(each.__file__) for each in list(sys.modules.values()) if getattr(each, "__file__", None)}
    names = [each.split(";")[0].split(">")[0].strip() for each in requires("frictionloop") if "extra ==" not in each]
    files = {name: distribution(name).files for name in names}
    return [name for name, all_of in files.items() if not loaded & {os.path.realpath(f.locate()) for f in all_of}]


def sizes_mb(site):
    """Return the size of each installed package in MB, with what Python has compiled of it."""
    found = {}
    for each in distributions(path=[str(site)]):
        files = {Path(file.locate()) for file in each.files or ()}
        found[each.metadata["Name"]] = sum(file.stat().st_size for file in files if file.is_file()) / 1e6
    return found


class Parts:
    """Processor time of what runs outermost, by name."""

    def __init__(self):
        self.seconds, self.depth = {}, 0

    def begin(self):
        """Enter a part; within another it counts as that."""
        self.depth += 1
        if self.depth == 1:
            self.since = time.process_time()

    def end(self, name):
        """Leave a part."""
        self.depth -= 1
        if self.depth == 0:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - self.since


def first_run(preset):
    """Run a preset in this process, and print the seconds of imports, of the compiler and of everything."""
    parts, imported = Parts(), builtins.__import__

    def importing(*given, **named):
        parts.begin()
        try:
            return imported(*given, **named)
        finally:
            parts.end("imports")

    builtins.__import__ = importing
    from numba.core import event

    class Compiler(event.Listener):
        def on_start(self, _):
            parts.begin()

        def on_end(self, _):
            parts.end("compiler")

    event.register("numba:compile", Compiler())
    verb("simulate", "--preset", preset, "--duration-s", "1")
    print(parts.seconds["imports"], parts.seconds.get("compiler", 0.0), time.process_time(), file=sys.stderr)


def first_runs(python):
    """Return imports, compiler, everything, and everything once more, of each preset, with an empty cache."""
    found = {}
    for preset in FIRST_S:
        with tempfile.TemporaryDirectory() as folder:
            own = {**os.environ, "NUMBA_CACHE_DIR": folder}
            own.pop("PYTHONPATH", None)
            run = [python, __file__, "--first", preset]
            told = [subprocess.run(run, cwd=folder, env=own, capture_output=True, text=True, check=True) for _ in "12"]
            cold, warm = ([float(each) for each in one.stderr.splitlines()[-1].split()] for one in told)
            found[preset] = (*cold, warm[-1])
    return found


def fresh(folder):
    """Install the package, without extras, into an environment; return it with the seconds that took."""
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-d", folder, "-t", "wheel"], cwd=ROOT, check=True)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "env"], check=True)
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        folder / "env",
        "install",
        "-q",
        "-c",
        ROOT / "requirements/lock.txt",
    ]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([*pip, *folder.glob("*.whl")], check=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return folder / "env", wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def page():
    """Return what was measured as tables."""
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        environment, wall, cpu = fresh(Path(folder))
        (site,) = environment.glob("lib/python*/site-packages")
        sizes = sizes_mb(site)
        runs = first_runs(environment / "bin/python")
    large = {name: size for name, size in sorted(sizes.items(), key=lambda each: -each[1]) if size >= SHOWN_MB}
    whole, others = sum(sizes.values()), len(sizes) - len(large)
    lines = ["| package | MB |", "|---|---|", *(f"| {name} | {size:.0f} |" for name, size in large.items())]
    lines += [f"| {others} others | {whole - sum(large.values()):.0f} |", f"| all, goal {MOST_MB} | {whole:.0f} |"]
    lines += ["", f"Installed in {wall:.0f} s, {cpu:.0f} s of a processor; goal {MOST_S} s.", ""]
    lines += [
        "| first `simulate`, 1 s | imports | Numba | rest | all | goal | again |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, (imports, compiler, everything, again) in runs.items():
        cells = imports, compiler, everything - imports - compiler, everything
        lines.append(
            f"| {name} | {' | '.join(f'{each:.1f} s' for each in cells)} | {FIRST_S[name]} s | {again:.1f} s |"
        )
    return "\n".join([*lines, "", f"Processor time; load of the machine before it began: {load:.1f}.", ""])


if __name__ == "__main__":
    if "--first" in sys.argv:
        first_run(sys.argv[-1])
    elif "--unused" in sys.argv:
        sys.exit(f"required and not used: {', '.join(found)}" if (found := unused()) else 0)
    else:
        print(text := page())
        if "--write" in sys.argv:
            RESULTS.write_text(text, encoding="utf-8")
