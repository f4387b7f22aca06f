"""New scene files: a short one, a copy of a shipped one, or one with every entry."""

from __future__ import annotations

import itertools
import json
import re
import shutil
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import tribo
from pipeline.paths import reason_of, user_path
from pipeline.scene.document import as_toml
from pipeline.scene.faults import did_you_mean
from pipeline.scene.reference import FILES, Listed, example, new_keys, plain_text, sections
from pipeline.scene.schema import scene_schema
from pipeline.scene.shipped import shipped_scenes
from pipeline.sweep.tables import entry_at
from tribo import InputError

SCHEMA_FILE = "irg.schema.json"
_MEANT, _LONGEST = 40, 80  # column in which comments begin, and their greatest length


def new_scene(path: str | Path, like: str | None = None, full: bool = False) -> list[Path]:
    """Write a scene to start from: a short scene, a shipped scene, or a scene with every entry.

    Parameters
    ----------
    path : path
        File to write; it must not exist yet.
    like : str, optional
        Name of a shipped scene to copy. By default a short scene whose diagram takes seconds.
    full : bool
        Add every other entry as a comment, with its meaning; not used with `like`.

    Returns
    -------
    list of Path
        The files written: the scene, copies of the files that it names, and, unless it is there,
        ``irg.schema.json``, by which editors complete and check scenes.

    Raises
    ------
    InputError
        If there is no such scene, the file exists or cannot be written, or is not called ``.toml``.

    Examples
    --------
    >>> import pipeline, tempfile
    >>> from pathlib import Path
    >>> folder = Path(tempfile.mkdtemp())
    >>> [file.name for file in pipeline.new_scene(folder / "mine.toml", like="fig8")]
    ['mine.toml', 'fig8_load_record.csv', 'irg.schema.json']
    """
    path, shipped = user_path(path), shipped_scenes()
    if path.suffix != ".toml":
        name = path.stem or "scene"
        raise InputError(f"{path}: a scene is a TOML file; give a name such as {name}.toml")
    if like is not None and like not in shipped:
        raise InputError(
            f'"{like}" is not a shipped scene{did_you_mean(like, shipped)}; there are '
            f"{', '.join(shipped)}"
        )
    short = resources.files("pipeline.scene").joinpath("template.toml")
    text = short.read_text(encoding="utf-8").replace("NAME", path.stem)
    copies = []
    if like is not None:
        text = shipped[like].read_text(encoding="utf-8")
        entries, folder = tomllib.loads(text), shipped[like].parent
        beside = [str(name) for key in FILES if (name := entry_at(entries, key))]
        copies = [(folder / name, path.parent / Path(name).name) for name in beside]
    elif full:
        head = "".join(itertools.takewhile(lambda line: line[0] == "#", text.splitlines(True)))
        text = "\n".join([head + _MARKS, *_scene_lines(tomllib.loads(text)), ""])
    files, schema = [path, *(copy for _, copy in copies)], path.parent / SCHEMA_FILE
    for file in files:
        if file.exists() or file.is_symlink():
            raise InputError(f"{file} exists already; give another name, or remove it")
    try:
        path.write_text(f"#:schema ./{SCHEMA_FILE}\n{text}", encoding="utf-8")
        for original, copy in copies:
            shutil.copyfile(original, copy)
        if not schema.exists():
            schema.write_text(schema_text(), encoding="utf-8")
            files.append(schema)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {reason_of(error, path)}") from error
    return files


_MARKS = '# An entry such as "#hold" is not used; take the # off to use it.'


def _scene_lines(entries: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines of a scene file with every entry of the format, as comments if not in use."""
    listed: Listed = {}
    for section in sections():
        table, _, name = section.path.partition(".")
        path, values = section.path, entry_at(entries, section.path) if section.path else entries
        if name == "NAME":
            ((name, values),) = entries[table].items()
            path = f"{table}.{name}"
        keys, like = new_keys(section, listed)
        meaning = f"Keys as in {like}, and these" if like else section.entry.meaning
        if path:
            yield _entry("" if values else "#", section.header.replace(section.path, path), meaning)
        for key, (entry, form) in keys.items():
            default = entry.default
            if path == "fidelity" and key != "preset":
                default = getattr(tribo.PRESETS[entries["fidelity"]["preset"]], key)
            mark, value = "#", example(entry, default)
            if key in (values or {}):
                mark, value = "", values[key]
            yield _entry(mark, f"{key} = {as_toml(value)}", entry.meaning, form and f" ({form})")


def _entry(mark: str, line: str, meaning: str, form: str = "") -> str:
    """Line of a scene file after a `mark` ("#" or none), with its meaning and form as a comment."""
    plain = plain_text(meaning)
    # The first sentence alone, or its first clause if the sentence is long.
    sentence = re.split(r"[;.](?: |$)", plain)[0]
    clause = sentence if len(sentence) <= _LONGEST else re.split("[,:] ", sentence)[0]
    return f"{mark + line:{_MEANT}} # {clause}{form}"


def schema_text() -> str:
    """JSON Schema of scenes, as a file."""
    return f"{json.dumps(scene_schema(), indent=2, ensure_ascii=False)}\n"
