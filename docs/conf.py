"""Settings of the documentation site: ``make docs``."""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(Path(__file__).resolve().parent))
os.environ.setdefault("GCM_LEARN_FAST", "1")  # notebooks draw fewer situations

from gcm_learn import __version__  # noqa: E402

project = "gcm_learn"
author = "The gcm_learn authors"
copyright = author
version = release = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "pages",
]
source_suffix = {".md": "myst-nb", ".py": "myst-nb"}
include_patterns = ["*.md", "api/*.md", "notebooks/*.md", "notebooks/*.py"]
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}
nb_execution_mode = os.environ.get("GCM_LEARN_DOCS", "cache")  # "off": pages without outputs
nb_execution_cache_path = str(ROOT / "build" / "notebooks")
nb_execution_timeout = 600
nb_execution_raise_on_error = True
suppress_warnings = ["mystnb.unknown_mime_type", "ref.python"]  # names stand in several doors

autodoc_default_options = {"members": True, "imported-members": True}
autodoc_typehints = "none"  # docstrings give types with shapes and units
autodoc_preserve_defaults = True
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "gcm_learn"
html_static_path: list[str] = []
html_show_sphinx = False
