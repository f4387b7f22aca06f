"""Markdown page of the commands and their options, from the parser."""

import argparse

from pipeline.cli.parser import whole_parser
from tests.helpers.campaigns import table

_OF_EACH = "help", "json", "quiet"
"""Destinations of the options that each command has."""


def commands():
    """Markdown of all commands: their table, and the options of each."""
    parsers = whole_parser().get_default("commands")
    rows = [
        [f"[`irg {name}`](#irg-{name})", _sentence(parser.description)]
        for name, parser in parsers.items()
    ]
    conditions = next(filter(None, map(_conditions, parsers.values())))
    return "\n".join(
        [
            "## All commands\n",
            table(("command", "purpose"), rows),
            "\n## Options of each command\n",
            _options(action for action in parsers["run"]._actions if action.dest in _OF_EACH),
            *(_section(name, parser, conditions) for name, parser in parsers.items()),
            "\n## Conditions\n",
            "These options replace conditions of the scene; answers then hold for them.\n",
            _options(conditions),
            "",
        ]
    )


def _section(name, parser, conditions):
    """Section on a command: its purpose, an example, its arguments and options."""
    own = [action for action in parser._actions if action.dest not in _OF_EACH]
    shared = [action.dest for action in conditions]
    has_conditions = _conditions(parser) is not None
    if has_conditions:
        own = [action for action in own if action.dest not in shared]
    also = "\n\nAnd the options for [conditions](#conditions)." if has_conditions else ""
    example = parser.epilog.partition("\n")[2].strip()
    parts = [f"\n## `irg {name}`\n", f"{_sentence(parser.description)}\n", f"```\n{example}\n```\n"]
    return "\n".join([*parts, _options(own) + also])


def _conditions(parser):
    """Options of the group of conditions of a command; None if it has none."""
    for group in parser._action_groups:
        if (group.title or "").startswith("conditions"):
            return group._group_actions
    return None


def _options(actions):
    """Table of arguments and options."""
    rows = [[_name(action), _meaning(action)] for action in actions]
    return table(("option", "meaning"), rows)


def _name(action):
    """How an argument or option is typed."""
    metavar = action.metavar or "|".join(map(str, action.choices or ()))
    if not action.option_strings:
        text = f"{metavar}, optional" if action.nargs == argparse.OPTIONAL else metavar
        return ", ".join([f"`{metavar}`", *text.split(", ")[1:]])
    value = f" {metavar}" if metavar and action.nargs != 0 else ""
    return ", ".join(f"`{option}{value}`" for option in action.option_strings).replace("|", "\\|")


def _meaning(action):
    """Help of an option in a cell of a table."""
    text = action.help.replace("%%", "%").replace("<", "&lt;").replace("|", "\\|")
    return f"{text[0].upper()}{text[1:]}"


def _sentence(text):
    return " ".join(text.split())
