"""Tables of refusals: what causes each, its kept message, and refusals that none causes."""

import ast
import contextlib
import io
import sys
import tempfile
import traceback
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import pipeline
from pipeline.cli import main
from tests.helpers.kept import assert_as_kept, relative
from tribo import TriboError

ROOT = Path(pipeline.__file__).resolve().parent


class Outcome(NamedTuple):
    """Message of a refusal in a folder, and (file, line, text) of all errors on the way to it."""

    message: str
    raised: list[tuple[str, int, str]]
    folder: Path


class Refusals:
    """Table of the refusals of a folder of code: functions by name, each run once.

    A function raises a `TriboError`, or returns the output of a command. A raising statement is
    covered if a table entry has caused its error, and the message of the entry contains its text.
    """

    def __init__(
        self,
        package: str,
        table: dict[str, Callable[[], Any]],
        folder: Path,
        stores: dict[str, Path] | None = None,
    ) -> None:
        self.package, self.table = (ROOT / package).resolve(), table
        self.folder, self.stores = folder, stores or {}
        self.outcomes: dict[str, Outcome] = {}

    def outcome(self, name: str) -> Outcome:
        """Outcome of a table entry; it runs in a folder with links to the stores."""
        if name not in self.outcomes:
            folder = Path(tempfile.mkdtemp(dir=self.folder))
            for link, store in self.stores.items():
                (folder / link).symlink_to(store)
            self.outcomes[name] = self._run(self.table[name], folder)
        return self.outcomes[name]

    def check_wording(self) -> None:
        """Assert that all refusals read as they are kept, in each letter."""
        of_stores = [store.parent for store in self.stores.values()]
        outcomes = {name: self.outcome(name) for name in self.table}
        texts = {
            name: relative(outcome.message, outcome.folder, *of_stores)
            for name, outcome in outcomes.items()
        }
        assert_as_kept(f"refusals_{self.package.stem}", texts)

    def check_all(self, elsewhere: Collection[str] = ()) -> None:
        """Assert that the table covers every error and fault except those tested `elsewhere`."""
        missing = self._missing()
        unknown = [
            f"{position} {name}" for name, position in missing.items() if name not in elsewhere
        ]
        assert unknown == [], "\n".join(["the table lacks", *unknown])
        assert sorted(elsewhere) == sorted(missing), "the table has what is said to be elsewhere"

    def _missing(self) -> dict[str, str]:
        """Errors and faults that no entry causes: file and line by function and class."""
        caused = {
            (file, line)
            for name in self.table
            for file, line, text in self.outcome(name).raised
            if text in " ".join(self.outcome(name).message.split())
        }
        return {
            name: f"{file}:{lines[0]}"
            for file, lines, name in self._statements()
            if not any((file, line) in caused for line in lines)
        }

    def _run(self, build: Callable[[], Any], folder: Path) -> Outcome:
        raised: list[tuple[str, int, str]] = []
        package = str(self.package)

        def on_error(frame: Any, event: str, argument: Any) -> Any:
            if event == "exception":
                text = " ".join(str(argument[1]).split())
                raised.append((frame.f_code.co_filename, frame.f_lineno, text))
            return on_error

        def on_call(frame: Any, event: str, argument: Any) -> Any:
            if frame.f_code.co_name == "refuse" and "problem" in frame.f_locals:
                text, caller = " ".join(frame.f_locals["problem"].split()), frame.f_back
                raised.append((caller.f_code.co_filename, caller.f_lineno, text))
            if not frame.f_code.co_filename.startswith(package):
                return None
            frame.f_trace_lines = False
            return on_error

        before = sys.gettrace()
        with contextlib.chdir(folder):
            sys.settrace(on_call)
            try:
                message = str(build())
            except TriboError as error:
                message = str(error)
                raised += _passed(error)
            finally:
                sys.settrace(before)
        return Outcome(message, raised, folder)

    def _statements(self) -> Iterator[tuple[str, range, str]]:
        """Yield file, lines and name of each statement that raises an error or refuses an entry."""
        for file in sorted(self.package.rglob("*.py")) if self.package.is_dir() else [self.package]:
            for function in ast.walk(ast.parse(file.read_text("utf-8"))):
                if isinstance(function, ast.FunctionDef):
                    for node in ast.walk(function):
                        if error := _refusal(node):
                            lines = range(node.lineno, node.end_lineno + 1)
                            yield str(file), lines, f"{file.stem}.{function.name} {error}".strip()


def _passed(error: BaseException | None) -> Iterator[tuple[str, int, str]]:
    """Yield (file, line, text) along the traceback of an error and of its causes."""
    while error is not None:
        for frame, line in traceback.walk_tb(error.__traceback__):
            yield frame.f_code.co_filename, line, str(error)
        error = error.__context__


def _refusal(node: ast.AST) -> str | None:
    """Class of the error that a statement raises, "fault" if it refuses an entry, else None."""
    match node:
        case ast.Raise(exc=ast.Call(func=error)):
            return ast.unparse(error)
        case ast.Call(func=ast.Attribute(attr="refuse")):
            return "fault"
    return None


def refusal_tests(
    package: str, table: dict[str, Any], elsewhere: Collection[str] = (), **stores: str
) -> tuple[Any, ...]:
    """Fixture and tests for the table of a folder; `stores` has names of fixtures by store name."""

    @pytest.fixture(scope="module")
    def refusals(request: Any, tmp_path_factory: Any) -> Refusals:
        links = {
            f"{name}.zarr": request.getfixturevalue(fixture) for name, fixture in stores.items()
        }
        return Refusals(package, table, tmp_path_factory.mktemp("refusals"), links)

    @pytest.mark.parametrize("name", table)
    def test_each_is_one_line(refusals: Refusals, name: str) -> None:
        message = refusals.outcome(name).message
        assert len(message.strip().splitlines()) == 1, message

    def test_all_read_as_they_are_kept(refusals: Refusals) -> None:
        refusals.check_wording()

    def test_all_are_here(refusals: Refusals) -> None:
        refusals.check_all(elsewhere)

    return refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here


def command(*arguments: Any) -> str:
    """Output of a command that is refused with exit code 2."""
    with contextlib.redirect_stderr(io.StringIO()) as printed, contextlib.redirect_stdout(printed):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as error:
            code = error.code
    assert code == 2, printed.getvalue()
    return printed.getvalue()
