"""Arrays of a dataset by the name of their variable, each read when it is first used."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from tribo.types import Array


class Columns(Mapping[str, Array]):
    """Arrays by name of their variable, each of which is read when it is first used."""

    def __init__(self, readers: Mapping[str, Callable[[], Array]]) -> None:
        self._readers, self._arrays = dict(readers), dict[str, Array]()

    def __getitem__(self, name: str) -> Array:
        if name not in self._arrays:
            self._arrays[name] = self._readers[name]()
        return self._arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self._readers

    def __iter__(self) -> Iterator[str]:
        return iter(self._readers)

    def __len__(self) -> int:
        return len(self._readers)


def taken(columns: Mapping[str, Array], take: Callable[[Array], Array]) -> Columns:
    """Columns with `take` of each array, which is read and taken when it is first used."""

    def reader(name: str) -> Callable[[], Array]:
        return lambda: take(columns[name])

    return Columns({name: reader(name) for name in columns})
