"""Results of campaigns, with the code that they speak of; and measured figures older than it.

python -m tests.helpers.campaigns      # figures of workflows/MEASURED.md that are older
"""

import re
import shlex
import subprocess
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "workflows" / "MEASURED.md"


def git(*arguments, root=ROOT):
    """Output of a git command, without its last line break; empty if it fails."""
    command = ["git", "-C", str(root), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def commit():
    """Short name of the checked-out commit, with "-dirty" if files differ."""
    return git("describe", "--always", "--dirty") or "unknown commit"


def table(columns, rows):
    """A Markdown table as text."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (columns, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(columns), *lines[1:]])


def save(name, found, is_right):
    """Write what a campaign found so far to ``results``, with its command, date and commit."""
    module = sys.modules["__main__"].__spec__.name.removesuffix(".__main__")
    command = shlex.join(["python", "-m", module, *sys.argv[1:]])
    verdict = "right" if is_right else "not right"
    path = Path("results", f"{name}.md")
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"`{command}`: {verdict}; {date.today():%m-%d}, {commit()}\n\n{found}\n")


def conclude(name, found, is_right):
    """Print and save what a campaign found; return the exit code, 0 if `is_right`."""
    save(name, found, is_right)
    print(found)
    return 0 if is_right else 1


def older(page, root=ROOT):
    """Yield a sentence on each figure of a page that is older than the last change of its rooms.

    Each section with figures has a line such as ``Rooms: `tribo`, `pipeline/store`.``
    """
    for section in re.split("^## ", page, flags=re.MULTILINE)[1:]:
        title, _, text = section.partition("\n")
        rooms = re.findall("`(.*?)`", "".join(re.findall("^Rooms: (.*)", text, re.MULTILINE)))
        for when, name in sorted(set(re.findall(r"(\d\d-\d\d), ([0-9a-f]{7,8})\b", text))):
            count = git("rev-list", "--count", f"{name}..HEAD", "--", *rooms, root=root)
            if count != "0":
                changed = f"{count} changes" if count else "an unknown number of changes"
                yield f"{title}: {when}, {name}: {changed} of {', '.join(rooms)} since"


if __name__ == "__main__":
    print("\n".join(older(PAGE.read_text(encoding="utf-8"))) or "no figure is older than its rooms")
