"""Configuration of the site that `make docs` builds of the pages in this folder."""

from importlib.metadata import version as installed_version

project = "irg-transition"
author = "The irg-transition developers"
version = release = installed_version(project)

extensions = ["myst_nb"]  # pages in Markdown, and notebooks
exclude_patterns = ["paper"]
html_theme = "furo"
html_title = "IRG transition diagrams"
html_static_path = ["print.css"]
html_css_files = [("print.css", {"media": "print"})]
smartquotes = False  # the dashes of options are two

myst_heading_anchors = 4
myst_enable_extensions = ["amsmath", "dollarmath"]
nb_execution_mode = "off"  # notebooks are shown as `make notebooks` stored them
