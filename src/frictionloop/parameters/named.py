"""Parameters of a System by a name without a block, or by what other programs call them."""

from __future__ import annotations

from frictionloop.parameters.guessed import meant
from frictionloop.parameters.system import System
from frictionloop.parameters.wording import known_names
from frictionloop.quantities import must_be

MOST = 3
"""Names that are proposed."""


def parameters_named(word: str) -> list[str]:
    """Return the dotted names that a word is the last part, the begin of it, or another name of.

    >>> parameters_named("kp")
    ['controller.kp']

    Parameters
    ----------
    word
        Name, with or without dashes.

    Raises
    ------
    FrictionloopError
        For no name.
    """
    if not word:
        raise must_be("word", word, "a name")
    asked = word.replace("-", "_")
    names = {name: name.rsplit(".", 1)[-1] for name in known_names(System, {}) if not name.endswith(".kind")}
    same = [name for name, leaf in names.items() if leaf == asked]
    blocks = [f"{asked}.kind"] if asked in System.model_fields else []
    tried = [meant(f"{block}.{asked}", None, list(names), {}) for block in System.model_fields if asked]
    guessed = [f"{each.name} ({each.how})" if each.how else each.name for each in tried if each]
    begun = [name for name, leaf in names.items() if asked and leaf.startswith(f"{asked}_")]
    return list(dict.fromkeys(same or blocks or guessed or begun))[:MOST]
