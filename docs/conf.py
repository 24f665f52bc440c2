"""Sphinx configuration: MyST pages whose code runs, an executed gallery, and the API from docstrings."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

import matplotlib as mpl

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_tools"))
mpl.use("Agg")

from look import LOOK  # noqa: E402

project = "frictionloop"
author = "frictionloop contributors"
copyright = "2026, frictionloop contributors"
release = version = installed_version("frictionloop")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx_gallery.gen_gallery",
    "computed",
    "docstrings",
    "executed",
    "studio_page",
]
exclude_patterns = ["_build", "gallery/**/*.ipynb", "gallery/**/*.py", "gallery/**/*.md5"]
default_role = "py:obj"

html_theme = "furo"
html_title = "frictionloop"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["pages.css"]

myst_enable_extensions = ["dollarmath", "amsmath", "substitution", "colon_fence", "deflist"]
myst_heading_anchors = 3

executed_pages = [
    "start",
    "tutorial",
    "will-it-ring",
    "controllers",
    "plate",
    "force-sensor",
    "findings",
    "verbs-in-python",
    "finger",
    "perception",
    "effects",
    "how-to/*",
]
executed_style = LOOK

autodoc_default_options = {"exclude-members": "model_config"}
autodoc_member_order = "bysource"
autodoc_typehints = "description"
napoleon_google_docstring = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "abort_on_example_error": True,
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "show_signature": False,
    "image_srcset": ["2x"],
    "reset_modules": ("matplotlib", "look.dress"),
}


def setup(app):
    """Say of an extension that copies files once the pages are written, and no more, that pages may be read in parallel."""
    app.extensions["sphinx-mathjax-offline"].parallel_read_safe = True
