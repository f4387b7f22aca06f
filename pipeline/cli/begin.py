"""The command that a user begins with: a scene to start from."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import show
from pipeline.run.site import write_sample
from pipeline.scene.editors import write_schema
from pipeline.scene.shipped import shipped_scenes
from tribo import InputError


def new(options: argparse.Namespace) -> int:
    """Write a scene to start from or the schema of scenes, or list those that are shipped."""
    if options.list:
        titles = {name: pipeline.load_scene(path).title for name, path in shipped_scenes().items()}
        show(options, titles, [f"{name:16} {title}" for name, title in titles.items()])
        return DONE
    if options.schema is not None:
        schema = write_schema(options.schema)
        text = [
            f"{schema} is written",
            f"editors go by it in a scene beside it whose first line is: #:schema ./{schema.name}",
        ]
        show(options, {"file": str(schema)}, text)
        return DONE
    if options.site is not None:
        site = write_sample(options.site)
        show(
            options,
            {"file": str(site)},
            [f"{site} is written", f"irg run SCENE.toml --cluster slurm --site {site}"],
        )
        return DONE
    if options.file is None:
        raise InputError("give the name of the file to write, such as: irg new scene.toml")
    scene, *copies = pipeline.new_scene(options.file, options.like)
    document = {"file": str(scene), "copies": [str(copy) for copy in copies]}
    text = [
        f"{scene} is written" + "".join(f", {copy} copied" for copy in copies),
        f"its meaning and cost: irg check {scene}",
        f"its points: irg run {scene}",
    ]
    show(options, document, text)
    return DONE
