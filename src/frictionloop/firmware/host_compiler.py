"""Build a shared library from C sources with whatever C compiler there is, once per machine."""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from frictionloop.quantities import FrictionloopError, replacing, why_unwritable
from frictionloop.quantities.compile_events import compiling
from frictionloop.quantities.file_integrity import append_seal, is_usable, why_untrusted
from frictionloop.quantities.optional_libraries import needed

FLAGS = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
"""How the firmware's core is built for the host; the same bits come out at any level of optimisation."""
_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}


def compiler() -> tuple[str, ...]:
    """Return the command of a C compiler: ``$CC``, else cc, else zig from the wheel ``ziglang``."""
    named = tuple(os.environ.get("CC", "cc").split()) or ("cc",)
    if shutil.which(named[0]):
        return named
    if find_spec("ziglang"):
        return zig()
    raise FrictionloopError("C compiler: none; install frictionloop[image]")


def zig() -> tuple[str, ...]:
    """Return the command of zig's C compiler, whether or not it is installed."""
    return (sys.executable, "-m", "ziglang", "cc")


def cache_folder() -> Path:
    """Return the user's folder for what can be built again at any time."""
    return Path(needed("platformdirs", "platformdirs", "firmware").user_cache_path("frictionloop", appauthor=False))


def shared_library(
    name: str,
    sources: Sequence[Path],
    include: Sequence[Path] = (),
    flags: Sequence[str] = FLAGS,
    command: Sequence[str] | None = None,
) -> Path:
    """Return the path of the library of some C sources, compiled unless that was done before.

    It lies in the user's cache under a name that tells sources, headers, flags, compiler and platform apart. Processes
    that build it at the same time do not disturb one another: each writes its own file and renames it. A damaged one is
    built anew; one that another user could have put there is not run.

    Parameters
    ----------
    name
        What its file name begins with.
    sources
        The C files.
    include
        Folders of headers.
    flags
        Flags of the compiler besides those that make a shared library.
    command
        The compiler; `compiler` by default.
    """
    command = tuple(command or compiler())
    given = (*flags, *(("-fno-sanitize=all",) if "ziglang" in command else ()))
    suffix = _SUFFIX.get(sys.platform, ".so")
    library = cache_folder() / f"{name}-{_key(sources, include, given, command)}{suffix}"
    if why := why_untrusted(library):
        raise FrictionloopError(f"{why}; delete it, or chmod go-w")
    if is_usable(library):
        return library
    cache = f"{library.parent}: cache"
    try:
        library.parent.mkdir(0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{cache} cannot be made ({error.strerror or error})") from None
    if why := why_unwritable(library.parent):  # the linker would not say why
        raise FrictionloopError(f"{cache} cannot be written ({why})")
    with compiling(), replacing(library) as fresh:
        folders = [f"-I{folder}" for folder in include]
        built = [*command, *given, "-fPIC", "-shared", *folders, *map(str, sources), "-o", str(fresh)]
        run(built, f"{name}: does not compile with {' '.join(command)}")
        append_seal(fresh)
    return library


def run(command: Sequence[str], otherwise: str, folder: Path | None = None) -> None:
    """Run a compiler in a folder; raise FrictionloopError with its first complaint where it fails."""
    done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True, errors="replace")
    if done.returncode:
        lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        first = next((line for line in lines if "error" in line), lines[0] if lines else "it does not say why")
        raise FrictionloopError(f"{otherwise}: {first}")


def _key(sources: Sequence[Path], include: Sequence[Path], flags: Sequence[str], command: Sequence[str]) -> str:
    digest = hashlib.sha256()
    headers = [header for folder in include for header in sorted(folder.glob("*.h"))]
    for path in (*sources, *headers):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    what = ("sealed", *flags, *command, _version(command), sys.platform, platform.machine())
    digest.update("\0".join(what).encode())
    return digest.hexdigest()[:20]


def _version(command: Sequence[str]) -> str:
    if "ziglang" in command:  # starting it takes longer than reading its version
        from importlib.metadata import version

        return version("ziglang")
    found = shutil.which(command[0])
    return f"{found} {Path(found).resolve().stat().st_mtime_ns}" if found else ""
