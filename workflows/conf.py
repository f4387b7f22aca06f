"""Configuration of the site that `make docs` builds of the pages in this folder."""

from importlib.metadata import version as installed_version

from pipeline.cli.parser import whole_parser

project = "irg-transition"
author = "The irg-transition developers"
version = release = installed_version(project)

extensions = [
    "myst_nb",  # pages in Markdown, and notebooks
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinxarg.ext",  # reference of the command, from its parser
]
exclude_patterns = ["paper"]
html_theme = "furo"
html_title = "IRG transition diagrams"
html_static_path = ["print.css"]
html_css_files = [("print.css", {"media": "print"})]
smartquotes = False  # the dashes of options are two

myst_heading_anchors = 4
myst_enable_extensions = ["amsmath", "dollarmath", "substitution"]
myst_substitutions = {
    "commands": "\n".join(
        [
            "| command | purpose |\n|---|---|",
            *(
                f"| `irg {name}` | {' '.join(command.description.split())} |"
                for name, command in whole_parser().get_default("commands").items()
            ),
        ]
    )
}
nb_execution_mode = "off"  # notebooks are shown as `make notebooks` stored them

default_role = "py:obj"  # names in backticks link to their entries
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_typehints = "none"  # types stand in the docstrings
autosummary_generate = False
numpydoc_show_class_members = False
suppress_warnings = [
    "myst.domains",  # warns that references cannot be looked up among commands
]
