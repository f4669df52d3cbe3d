"""Sphinx settings: pages in Markdown, the Python interface from its docstrings."""

from importlib.metadata import version as installed_version

project = "hypertuna"
author = "the hypertuna authors"
project_copyright = author
release = version = installed_version("hypertuna")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["_build"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_member_order = "bysource"
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"hypertuna {release}"
