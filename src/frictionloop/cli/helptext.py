"""How help looks: names and meanings in two columns under plain headings, no boxes."""

from __future__ import annotations
