"""What all tests share: how hypothesis searches."""

from __future__ import annotations

from hypothesis import settings

# The same examples on every machine, and no deadline, because the first example compiles the kernel.
settings.register_profile("default", deadline=None, derandomize=True, max_examples=100)
# `pytest --hypothesis-profile=explore` looks further, with new examples each time.
settings.register_profile("explore", deadline=None, max_examples=2000)
settings.load_profile("default")
