"""The site of the pages, built by Sphinx from the root of the repository: `make docs`.

The pages are those of the repository, in their folders, and links between them are those of its web view.
Nothing is fetched from elsewhere, neither when the site is built nor when it is read.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT), str(ROOT / "modelDescription")]

from sim_scenarios import toml  # noqa: E402

project = "TrueNorth"
release = toml.read(ROOT / "pyproject.toml")["project"]["version"]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "order", "parameters"]

root_doc = "README"
include_patterns = ["*.md", "docs/**.md", "examples/*.md", "modelDescription/*.md", "fmu_src/*/*.md"]
exclude_patterns = [".*", "build", "sim_scenarios", "tests"]
smartquotes = False
default_role = "code"
highlight_language = "none"  # most blocks are commands
suppress_warnings = ["misc.highlighting_failure"]  # a sketch in TOML need not be TOML
myst_heading_anchors = 4
autodoc_typehints = "none"  # the docstrings have them
autodoc_preserve_defaults = True

html_theme = "furo"
html_theme_options = {"dark_css_variables": {"color-background-primary": "#0d1117"}}
html_title = f"TrueNorth {release}"
html_extra_path = ["index.html"]
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_show_copyright = html_copy_source = html_use_index = html_domain_indices = False
html_show_search_summary = False  # would be fetched, which a browser refuses to a page of a folder
