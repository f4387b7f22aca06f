"""No room grows unnoticed: its size may rise only in a commit that names the file of sizes."""

import subprocess
import tomllib

import pytest

from tests.house.measure import ROOT, SIZES, measured, written


def flat(sizes):
    return {(table, name): size for table, names in sizes.items() for name, size in names.items()}


def grown(before, after):
    """Names of sizes that are larger than before, or new."""
    before, after = flat(before), flat(after)
    return [f"{name[1]}: {size} > {before.get(name, 0)} {name[0]}" for name, size in after.items()
            if size > before.get(name, 0)]  # fmt: skip


def test_no_size_exceeds_that_of_the_file():
    """`python -m tests.house` writes them anew."""
    allowed = tomllib.loads(SIZES.read_text(encoding="utf-8"))
    larger = grown(allowed, measured())
    advice = "write them anew: python -m tests.house; the commit names sizes.toml and says why"
    assert larger == [], "\n".join([*larger, advice])


def test_what_grows_is_noticed():
    before = measured()
    after = tomllib.loads(written(before))
    assert grown(before, after) == []
    after["lines of code"]["pipeline.run"] += 1
    after["lines of code"]["pipeline.new"] = 5
    assert len(grown(before, after)) == 2


def git(*words):
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else None


def test_a_size_rises_only_in_a_commit_that_names_the_file():
    path = SIZES.relative_to(ROOT).as_posix()
    commits = git("log", "-20", "--format=%H", "--", path)
    if not commits:
        pytest.skip("no history here")
    for commit in commits.split():
        before, after = git("show", f"{commit}^:{path}"), git("show", f"{commit}:{path}")
        if before and after and grown(tomllib.loads(before), tomllib.loads(after)):
            assert SIZES.name in git("log", "-1", "--format=%B", commit), commit
