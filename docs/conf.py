"""Settings of the site; `make docs` builds it."""

import sys
from pathlib import Path

import granwave

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "granwave"
author = "The granwave developers"
copyright = "the granwave developers; GPL-2.0"
version = release = granwave.__version__

extensions = [
    "myst_nb",  # Markdown, and notebooks, which are run
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_design",
    "sphinx_copybutton",
    "code_tables",  # reference pages from the code's own tables, in _ext
    "studies",  # the gallery, in _ext
    "mathml",  # equations without a script, in _ext
    "math_font",  # the font of the equations, in _ext
    "index_entries",  # entries of the index for rows of tables, in _ext
    "menu_groups",  # headings of groups in the menu, in _ext
    "page_elements",  # pictures that enlarge, breaks in code, numbers and units, in _ext
    "notebook_links",  # links to the files of notebooks, in _ext
]
html_math_renderer = "mathml"
myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 60
exclude_patterns = ["_ext", "gallery/*.py", "paper"]
default_role = "code"
smartquotes = False  # values are quoted as in files
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # types in signatures; links that pages write are checked

html_theme = "furo"
html_title = f"granwave {version}"
html_search_scorer = str(Path(__file__).parent / "_ext" / "scorer.js")
html_static_path = ["_static"]
html_css_files = ["granwave.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0072B2", "color-brand-content": "#0072B2"},
    "dark_css_variables": {"color-brand-primary": "#56B4E9", "color-brand-content": "#56B4E9"},
}
copybutton_exclude = ".linenos, .gp, .go"

autodoc_typehints = "none"  # numpydoc texts say the types that matter
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
