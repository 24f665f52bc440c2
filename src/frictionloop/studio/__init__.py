"""The live page: slide on the plate, see and compare, in a browser.

serve  export  desk   the page until Ctrl-C, a page that plays runs without a server, the pages of an experiment
"""

from __future__ import annotations

from frictionloop.quantities.optional_libraries import lazily

HOMES = {"opened_studio": "ExportedPage Opened desk export serve"}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
