"""Markdown page of the public names in Python, from their docstrings."""

import inspect
import re
import textwrap

from numpydoc.docscrape import NumpyDocString

import pipeline
import pipeline.answers.simulated_points
import pipeline.progress
import pipeline.run.estimate
import pipeline.run.run_sweep
import pipeline.run.trade
import pipeline.store.status
import pipeline.sweep.plan
import tribo
import tribo.contact
import tribo.inverse
import tribo.loading
import tribo.simulation
import tribo.thermal

_WIDTH = 88  # letters of code in the site's page
_RETURNED = {
    "pipeline": (
        pipeline.sweep.plan.PointResult,
        pipeline.run.estimate.Estimate,
        pipeline.run.run_sweep.RunSummary,
        pipeline.progress.Progress,
        pipeline.store.status.Summary,
        pipeline.store.status.Verification,
        pipeline.answers.simulated_points.WarnedPoints,
        pipeline.run.trade.Trade,
        pipeline.run.trade.MeasuredCost,
    ),
    "tribo": (
        tribo.contact.solve_contact,
        tribo.thermal.partition_heat,
        tribo.contact.ContactSolution,
        tribo.thermal.HeatPartition,
        tribo.simulation.Heat,
        tribo.simulation.PointWarning,
        tribo.inverse.WearRate,
        tribo.loading.LoadStep,
    ),
}
"""Objects that the page describes below a package, which users meet by its functions."""


def api():
    """Markdown of all public names of `pipeline`, `tribo` and `tribo.analytic`."""
    names = {
        "pipeline": sorted(set(pipeline.__all__) - {"Conditions"}, key=str.lower),
        "tribo": _public(tribo),
        "tribo.analytic": _public(tribo.analytic),
    }
    packages = {"pipeline": pipeline, "tribo": tribo, "tribo.analytic": tribo.analytic}
    parts = []
    for package, module in packages.items():
        parts.append(f"## `{package}`\n")
        for name in names[package]:
            parts.append(_entry(f"{package}.{name}", getattr(module, name)))
        if returned := _RETURNED.get(package):
            parts.append(f"## Further names of `{package}`\n")
            parts += [_entry(_path(thing), thing) for thing in returned]
    return "\n".join(parts)


def _public(module):
    """Documented functions and classes of a module, in the order in which they are defined."""
    return [
        name
        for name, thing in vars(module).items()
        if not name.startswith("_")
        and (inspect.isclass(thing) or inspect.isfunction(thing))
        and thing.__module__.startswith(module.__name__)
    ]


def _path(thing):
    """Shortest public path of an object of the packages."""
    package = thing.__module__.rpartition(".")[0]
    module = __import__(package, fromlist=[""])
    is_there = hasattr(module, thing.__name__) and package.startswith("tribo")
    return f"{package if is_there else thing.__module__}.{thing.__name__}"


def _entry(path, thing, level=3):
    """Section on a function or class: its call, its docstring, and its documented members."""
    text = inspect.getdoc(thing) or ""
    is_error = inspect.isclass(thing) and issubclass(thing, Exception)
    parts = [f"{'#' * level} `{path}`\n"]
    is_bare_class = inspect.isclass(thing) and "Parameters\n---" not in text
    if not is_error and not is_bare_class and (call := _call(path, thing)):
        parts.append(f"```py\n{call}\n```\n")
    parts += _documented(text)
    if inspect.isclass(thing) and not is_error:
        parts += _members(path.rpartition(".")[2], thing)
    return "\n".join(parts)


def _members(owner_name, owner):
    """Documented public methods and properties of a class: a list, and sections of long ones."""
    items, sections = [], []
    for name, member in vars(owner).items():
        function = getattr(member, "fget", None) or getattr(member, "func", None) or member
        function = getattr(function, "__func__", function)
        is_own = inspect.isfunction(function) and function.__module__ == owner.__module__
        text = inspect.getdoc(function) if is_own and not name.startswith("_") else None
        if not text:
            continue
        is_value = isinstance(member, property) or hasattr(member, "func")
        if "\n---" in text and not is_value:
            sections.append(_entry(f"{owner_name}.{name}", function, 4))
        else:
            head = (
                name if is_value else _call(name, function).replace("\n    ", "").replace("\n", "")
            )
            items.append(f"- `{head}`: {' '.join(_markdown(text.partition('---')[0]).split())}")
    return ["**Members**\n", "\n".join(items) + "\n", *sections] if items else sections


def _call(path, thing):
    """How a function or class is called: names and defaults, without types."""
    try:
        parameters = list(inspect.signature(thing).parameters.values())
    except ValueError:
        return ""
    if getattr(thing, "_is_protocol", False):
        return ""
    texts, is_keyword = [], False
    for parameter in parameters:
        if parameter.name in ("self", "cls"):
            continue
        if parameter.kind is parameter.VAR_POSITIONAL:
            is_keyword = True
        elif parameter.kind is parameter.KEYWORD_ONLY and not is_keyword:
            texts.append("*")
            is_keyword = True
        plain = parameter.replace(annotation=parameter.empty)
        if parameter.default is not parameter.empty:
            plain = plain.replace(default=_Shown(_default(parameter.default)))
        texts.append(str(plain).replace(" = ", "="))
    line = f"{path}({', '.join(texts)})"
    if len(line) <= _WIDTH:
        return line
    inner = textwrap.wrap(
        ", ".join(texts), _WIDTH - 4, break_long_words=False, break_on_hyphens=False
    )
    return f"{path}(\n" + "\n".join(f"    {part}" for part in inner) + "\n)"


class _Shown:
    """A default value that prints as a text."""

    def __init__(self, text):
        self.text = text

    def __repr__(self):
        return self.text


def _default(value):
    """Default value as it is typed; a name without its module for objects."""
    text = repr(value)
    if text == "<factory>":
        return "..."
    return re.sub(r"<(?:function|class) '?([\w.]+).*>", r"\1", text) if "<" in text else text


def _documented(text):
    """Parts of a docstring in Markdown: text, parameters, returns, errors, notes, examples."""
    doc = NumpyDocString(text)
    for name in ("Summary", "Extended Summary"):
        if lines := doc[name]:
            yield _markdown("\n".join(lines)) + "\n"
    for name in ("Parameters", "Attributes", "Other Parameters", "Returns", "Yields", "Raises"):
        if doc[name]:
            yield f"**{name}**\n"
            yield "\n".join(map(_item, doc[name])) + "\n"
    if doc["Notes"]:
        yield "**Notes**\n"
        yield _markdown("\n".join(doc["Notes"])) + "\n"
    examples = "\n".join(doc["Examples"]).strip()
    if examples := re.sub(r" +# doctest: .*", "", examples):
        yield "**Example**\n"
        for paragraph in examples.split("\n\n"):
            is_code = paragraph.startswith(">>>")
            yield f"```pycon\n{paragraph}\n```\n" if is_code else f"{_markdown(paragraph)}\n"


def _item(parameter):
    """List item of a parameter, a returned value or an error."""
    name, kind, lines = parameter
    described = _markdown("\n".join(lines)).strip()
    heads = [f"`{part}`" for part in re.split(r",\s*", name)] if name else []
    head = ", ".join(heads) + (f" ({_plain(kind)})" if name and kind else "")
    head = head or f"`{kind}`"
    indented = textwrap.indent(described, "  ").strip()
    return f"- {head}: {indented}" if indented else f"- {head}"


def _markdown(text):
    """Text of a docstring in Markdown: code by single marks, and literal blocks indented."""
    text = re.sub(r"``(.+?)``", r"`\1`", text, flags=re.DOTALL)
    text = re.sub(r"::$", ":", text, flags=re.MULTILINE)
    return re.sub(r"(`[^`]*`)|([<|$\\])", lambda match: match[1] or f"\\{match[2]}", text)


def _plain(text):
    return re.sub(r"([<|$\\])", r"\\\1", re.sub(r"``(.+?)``", r"`\1`", text))
