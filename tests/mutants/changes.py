"""Small faults that a module may have: one operator, number, condition or statement is another."""

import ast
import copy
from collections.abc import Iterator
from dataclasses import dataclass

_OTHER = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
    ast.Break: ast.Continue, ast.Continue: ast.Break,
}  # fmt: skip
_NAMES = {"min": "max", "any": "all", "minimum": "maximum", "argmin": "argmax", "floor": "ceil"}
_NAMES |= {other: name for name, other in _NAMES.items()}
# Not changed: annotations, and keywords that only control checks or speed and change no result.
_FIELDS = {"annotation", "returns", "decorator_list"}
_KEYWORDS = {"strict", "stacklevel", "slots", "frozen", "repr"}


@dataclass(frozen=True)
class Change:
    """A replacement of a node in a syntax tree, and the lines that have to run for it to matter."""

    parent: ast.AST
    field: str
    index: int | None
    node: ast.AST
    lines: range
    is_in_function: bool

    def __str__(self):
        return f"{ast.unparse(self._old)} → {ast.unparse(self.node)}".replace("\n", " ")

    @property
    def _old(self):
        value = getattr(self.parent, self.field)
        return value if self.index is None else value[self.index]

    def make(self):
        """Put the replacement into the tree."""
        if self.index is None:
            setattr(self.parent, self.field, self.node)
        else:
            getattr(self.parent, self.field)[self.index] = self.node


def changes(tree: ast.AST, first=0, is_in_function=False) -> Iterator[Change]:
    """Yield all changes of a syntax tree, always in the same order."""
    for field, value in ast.iter_fields(tree):
        if field in _FIELDS or (field == "test" and "TYPE_CHECKING" in ast.unparse(value)):
            continue
        for index, node in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if not isinstance(node, ast.AST):
                continue
            if isinstance(node, ast.keyword) and node.arg in _KEYWORDS:
                continue
            begin = node.lineno if isinstance(node, ast.stmt) else first
            inside = is_in_function or (
                isinstance(tree, ast.FunctionDef | ast.Lambda) and field == "body"
            )
            for other in _faults(node, field):
                ast.copy_location(other, node)
                lines = range(begin, node.end_lineno + 1)
                yield Change(tree, field, index, ast.fix_missing_locations(other), lines, inside)
            yield from changes(node, begin, inside)


def _faults(node: ast.AST, field: str) -> Iterator[ast.AST]:
    """Yield nodes that replace a node by a fault, such as another operator."""
    if field in ("test", "ifs"):
        yield ast.UnaryOp(ast.Not(), node)
    match node:
        case ast.Compare(ops=ops):
            for index, op in enumerate(ops):
                others = [_OTHER[type(op)]()]
                yield _like(node, ops=ops[:index] + others + ops[index + 1 :])
        case ast.BinOp(op=op) | ast.BoolOp(op=op) | ast.AugAssign(op=op) if type(op) in _OTHER:
            yield _like(node, op=_OTHER[type(op)]())
        case ast.UnaryOp(operand=operand):
            yield operand
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
        case ast.Constant(value=float(value)):
            yield ast.Constant(1.05 * value or 1.0)
        case ast.Name(id=name) if name in _NAMES:
            yield _like(node, id=_NAMES[name])
        case ast.Attribute(attr=name) if name in _NAMES:
            yield _like(node, attr=_NAMES[name])
        case ast.Break() | ast.Continue():
            yield _OTHER[type(node)]()
        case ast.Expr(value=ast.Call()) | ast.Raise():
            yield ast.Pass()


def _like(node, **fields):
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other
