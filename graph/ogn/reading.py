"""Reads the text of an `.ogn` file to a declaration; all its mistakes are reported at once, each with its place."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from graph.base.errors import Problem, UserError
from graph.files.json_text import parse
from graph.files.source import Source
from graph.files.text import described, suggestion
from graph.files.tree import Map
from graph.node.declaration import UNSET, Attribute, Role
from graph.values.coercion import coerce
from graph.values.types import Extended

NODE_KEYS = (
    *("version", "description", "language", "uiName", "icon", "tags", "categories", "categoryDefinitions", "metadata"),
    *("scheduling", "memoryType", "cudaPointers", "singleton", "exclude", "tokens", "inputs", "outputs", "state"),
    "tests",
)
ATTRIBUTE_KEYS = (
    *("type", "description", "default", "optional", "minimum", "maximum", "memoryType", "metadata", "uiName", "uiType"),
    *("unvalidated", "deprecated", "allowedTokens"),
)
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(:[A-Za-z0-9_]+)*")
ROLES: dict[str, Role] = {
    "inputs.cameraPrim": "sensor",
    "inputs.renderProductPath": "product",
    "inputs.timeStamp": "stamp",
    "outputs.renderProductPath": "product",
}
"""Roles by attribute name, as OmniGraph's own nodes use these names; the format has no field for a role."""
_USD_TUPLE = re.compile(r"^(double|float|half|int)([234])(?=(?:\[\])?$)")
"""USD's names of plain tuples, which some declarations use for `float[3]` and others."""


@dataclass(slots=True)
class OgnNode:
    """The content of an `.ogn` file. volatile: it reads more than its inputs; tokens: texts and their names."""

    id: str
    version: int
    doc: str
    inputs: dict[str, Attribute] = field(default_factory=dict)
    outputs: dict[str, Attribute] = field(default_factory=dict)
    state: dict[str, Attribute] = field(default_factory=dict)
    tokens: dict[str, str] = field(default_factory=dict)
    volatile: bool = False
    line: int = 1

    @property
    def is_event(self) -> bool:
        """Whether execution starts at it: it has execution outputs and no execution input."""
        return any(one.is_execution for one in self.outputs.values()) and not any(
            one.is_execution for one in self.inputs.values()
        )


def read_ogn(text: str, *, name: str, extension: str = "") -> OgnNode:
    """The declaration in an `.ogn` text.

    `name` is used in messages; `extension` is the prefix of a type name without a dot.

    Raises UserError with every problem, each with line and column.
    """
    source = Source(name, text)
    problems: list[Problem] = []
    root, at = parse(source, problems)
    reader = _Reader(source, problems)
    node = reader.node(root, at, extension)
    if problems or node is None:
        raise UserError(sorted(problems, key=lambda one: (one.mark.line, one.mark.column) if one.mark else (0, 0)))
    return node


class _Reader:
    def __init__(self, source: Source, problems: list[Problem]) -> None:
        self._source, self._problems = source, problems

    def node(self, root: Any, at: int, extension: str) -> OgnNode | None:
        """The one node of the file."""
        if not isinstance(root, Map) or len(names := [key for key in root if not key.startswith("$")]) != 1:
            self._wrong(at, "an .ogn file is a mapping with one key, the name of its node type")
            return None
        name, body = names[0], root[names[0]]
        name_at, body_at = root.places[name]
        if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", name):
            self._wrong(name_at, f'"{name}" is not a type name; use letters, digits, underscores and dots')
        if not isinstance(body, Map):
            self._wrong(body_at, f"expected a mapping, found {described(body)}")
            return None
        self._unknown(body, NODE_KEYS)
        node = OgnNode(name if "." in name else f"{extension}.{name}".lstrip("."), self._version(body, name_at), "")
        node.doc = self._text(body, "description", name_at)
        node.line = self._source.mark(name_at).line
        node.tokens = self._tokens(body)
        hints = self._texts(body, "scheduling")
        node.volatile = any(hint.split("-")[0] in ("usd", "global", "static", "topology") for hint in hints)
        for group in ("inputs", "outputs", "state"):
            getattr(node, group).update(self._attributes(body, group))
        return node

    def _attributes(self, body: Map, group: str) -> dict[str, Attribute]:
        declared = body.get(group, Map())
        if not isinstance(declared, Map):
            self._wrong(body.places[group][1], f"{group}: expected a mapping, found {described(declared)}")
            return {}
        found = {}
        for name, one in declared.items():
            if name.startswith("$"):
                continue
            key_at, value_at = declared.places[name]
            if not _NAME.fullmatch(name):
                self._wrong(key_at, f'"{name}" is not an attribute name; use letters, digits, underscores and ":"')
            elif not isinstance(one, Map):
                self._wrong(value_at, f"{group}.{name}: expected a mapping, found {described(one)}")
            else:
                attribute = self._attribute(one, f"{group}.{name}", key_at)
                if attribute is not None:
                    found[name] = attribute
        return found

    def _attribute(self, one: Map, where: str, at: int) -> Attribute | None:
        self._unknown(one, ATTRIBUTE_KEYS)
        declared = one.get("type")
        if not (
            isinstance(declared, str) or (isinstance(declared, list) and all(isinstance(t, str) for t in declared))
        ):
            place = one.places["type"][1] if "type" in one else at
            self._wrong(place, f"{where}: give it a type, such as double, or a list of types")
            return None
        given = one.get("metadata")
        metadata = given if isinstance(given, Map) else Map()
        idle = declared == "execution" and not one.get("default")  # many files write 0 for a node that is not triggered
        attribute = Attribute(
            _USD_TUPLE.sub(r"\1[\2]", declared) if isinstance(declared, str) else tuple(declared),
            self._text(one, "description", at),
            default=UNSET if idle else one.get("default", UNSET),
            optional=bool(one.get("optional", False)),
            literal_only=_true(metadata.get("literalOnly")),
            output_only=_true(metadata.get("outputOnly")),
            allowed_tokens=self._texts(one if "allowedTokens" in one else metadata, "allowedTokens", split=True),
            minimum=self._bound(one, "minimum"),
            maximum=self._bound(one, "maximum"),
            deprecated="\n".join(self._texts(one, "deprecated")),
            role=ROLES.get(where, ""),
        )
        try:
            parsed = attribute.parsed
        except ValueError as error:
            self._wrong(one.places["type"][1], f"{where}: {error}")
            return None
        if "default" in one and not idle and not isinstance(parsed, Extended):
            try:
                coerce(parsed, one["default"])
            except ValueError as error:
                self._wrong(one.places["default"][1], f"{where}: default: {error}")
                return None
        return attribute

    def _version(self, body: Map, at: int) -> int:
        version = body.get("version", 1)
        if isinstance(version, bool) or not isinstance(version, int) or version < 1:
            self._wrong(
                body.places["version"][1], f"version: expected a whole number from 1, found {described(version)}"
            )
            return 1
        return version

    def _text(self, body: Map, key: str, at: int) -> str:
        """A text, or a list of its lines; required."""
        value = body.get(key)
        if isinstance(value, str):
            return value
        if isinstance(value, list) and _is_text(value):
            return "\n".join(value)
        self._wrong(body.places[key][1] if key in body else at, f"{key}: give it a text, or a list of lines")
        return ""

    def _bound(self, one: Map, key: str) -> float | None:
        value = one.get(key)
        if value is None or isinstance(value, (int, float, list)):
            return value if isinstance(value, (int, float)) else None
        self._wrong(one.places[key][1], f"{key}: expected a number, found {described(value)}")
        return None

    def _tokens(self, body: Map) -> dict[str, str]:
        tokens = body.get("tokens")
        if isinstance(tokens, Map) and all(isinstance(one, str) for one in tokens.values()):
            return dict(tokens)
        return {one: one for one in self._texts(body, "tokens")}

    def _texts(self, body: Map, key: str, *, split: bool = False) -> tuple[str, ...]:
        """A text, a list of texts, or a mapping to texts, as a tuple; `split`: a text may be a list with commas."""
        value = body.get(key, [])
        if isinstance(value, str):
            return tuple(one.strip() for one in value.split(",")) if split else (value,)
        found = [*value.values()] if isinstance(value, Map) else value
        if isinstance(found, list) and all(isinstance(one, str) for one in found):
            return tuple(found)
        self._wrong(body.places[key][1], f"{key}: expected a text or a list of texts, found {described(value)}")
        return ()

    def _unknown(self, body: Map, known: tuple[str, ...]) -> None:
        for key in body:
            if key not in known and not key.startswith("$"):
                self._wrong(body.places[key][0], f'unknown key "{key}"{suggestion(key, known)}')

    def _wrong(self, at: int, message: str) -> None:
        self._problems.append(self._source.problem(at, message))


def _is_text(value: Any) -> bool:
    """Whether it is a text or a list of texts."""
    return isinstance(value, str) or (
        isinstance(value, list) and bool(value) and all(isinstance(one, str) for one in value)
    )


def _true(value: Any) -> bool:
    """Whether a flag in the metadata, where every value is text, is set."""
    return str(value).lower() in ("1", "true")
