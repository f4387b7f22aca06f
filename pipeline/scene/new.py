"""New scene files: a short one, or a copy of a shipped one."""

from __future__ import annotations

import re
import shutil
from importlib import resources
from pathlib import Path

from pipeline.messages import did_you_mean
from pipeline.paths import reason_of, user_path
from pipeline.shipped import shipped_scenes
from tribo import InputError


def new_scene(path: str | Path, like: str | None = None) -> list[Path]:
    """Write a scene to start from: a short scene, or a shipped one.

    Parameters
    ----------
    path : path
        File to write; it must not exist yet.
    like : str, optional
        Name of a shipped scene to copy. By default a short scene whose diagram takes seconds.

    Returns
    -------
    list of Path
        The files written: the scene, copies of the files that it names, and of the script that
        prints its rows.

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
    ['mine.toml', 'fig8_load_record.csv']
    """
    path, shipped = user_path(path), shipped_scenes()
    if path.suffix != ".toml":
        name = path.stem or "scene"
        raise InputError(f"{path}: a scene is a TOML file; give a name such as {name}.toml")
    if like is not None and like not in shipped:
        raise InputError(
            f'"{like}" is not a shipped scene{did_you_mean(like, shipped)}; available: '
            f"{', '.join(shipped)}"
        )
    template = resources.files("pipeline.scene").joinpath("template.toml")
    text = template.read_text(encoding="utf-8").replace("NAME", path.stem)
    copies = list[tuple[Path, Path]]()
    if like is not None:
        text = shipped[like].read_text(encoding="utf-8")
        folder, names = shipped[like].parent, [*re.findall(r'"([\w.]+)"', text), f"{like}.py"]
        originals = (folder / name for name in names)  # files that it names, and its script
        copies = [(file, path.parent / file.name) for file in originals if file.is_file()]
    files = [path, *(copy for _, copy in copies)]
    for file in files:
        if file.exists() or file.is_symlink():
            raise InputError(f"{file} already exists; choose another name, or delete it")
    try:
        path.write_text(text, encoding="utf-8")
        for original, copy in copies:
            shutil.copyfile(original, copy)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {reason_of(error, path)}") from error
    return files
