"""Forms: what the mappings of a file hold, declared as classes with annotated fields.

A form checks plain data, as a parser gives it, and collects every error with its location; the JSON Schema of the
format comes from the same declarations. Types are strict: a field takes `str`, `bool`, `int`, `float` (whole numbers
too), `Any`, a `Literal`, a `dict`, a `list`, another form, unions, and what `Annotated` adds: `Check`, `Before`,
`Wrap` and the limits of `Field`. A key whose value is null counts as absent.

The declarations are pydantic's. Importing pydantic takes as long as all that `graph check` imports of its own.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import asdict, is_dataclass
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Self,
    TypeAlias,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

from .records import dataclass, field

Location: TypeAlias = tuple[str | int, ...]
"""Keys and indices from the root; an error of a key itself ends in `KEY`."""

KEY = "[key]"
Schema: TypeAlias = dict[str, Any]


class Refused(ValueError):  # noqa: N818  (an error of the data, which the form collects)
    """Raised by a check; its text is the message."""


class Error(NamedTuple):
    """One error: its kind (`missing`, `unknown`, `refused`, `limit`, `choice`, or the type wanted) and its place."""

    kind: str
    location: Location
    detail: Any = None
    """refused: the text; limit: (name of the limit, its value); choice: the choices."""


class FormError(ValueError):
    """Data does not fit its form."""

    def __init__(self, errors: list[Error]) -> None:
        super().__init__(f"{len(errors)} errors, first {errors[0]}")
        self.errors = errors


@dataclass(frozen=True, eq=False)
class Check:
    """Stands for the whole type: `read` gives the value or raises Refused."""

    read: Callable[[Any], Any]
    schema: Schema


@dataclass(frozen=True, eq=False)
class Before:
    """Changes the data before the type is checked. accepts: the type that a file may hold, or its schema."""

    change: Callable[[Any], Any]
    accepts: Any = None


@dataclass(frozen=True, eq=False)
class Wrap:
    """Reads the data itself, or passes it on to the type. accepts: the type that a file may hold, for the schema."""

    read: Callable[[Any, Callable[[Any], Any]], Any]
    accepts: Any = None


@dataclass(frozen=True, eq=False, kw_only=True)
class FieldInfo:
    """A field's default, description and limits; without default and factory it must be present."""

    default: Any = ...
    default_factory: Callable[[], Any] | None = None
    description: str | None = None
    limits: Mapping[str, int] = field(default_factory=dict)
    """By name: min_length and max_length of text and mappings, ge and le of numbers."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """Further keys of the JSON Schema."""

    @property
    def required(self) -> bool:
        """Whether the key must be present."""
        return self.default is ... and self.default_factory is None

    def initial(self) -> Any:
        """The value of an absent key."""
        return self.default_factory() if self.default_factory is not None else self.default


def Field(
    *,
    default: Any = ...,
    default_factory: Callable[[], Any] | None = None,
    description: str | None = None,
    more: Mapping[str, Any] | None = None,
    **limits: int,
) -> Any:
    """Declares a field. limits: min_length, max_length, ge, le. more: further keys of its JSON Schema."""
    about = {"default": default, "default_factory": default_factory, "description": description}
    return FieldInfo(**about, limits=limits, more=more or {})


Read: TypeAlias = Callable[[Any, Location, list[Error]], Any]


class Kind(NamedTuple):
    """A type: how data is read, which adds to a list of errors, and its schema, which adds to the definitions."""

    read: Read
    schema: Callable[[Schema], Schema]


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(Field,))
class Form:
    """A mapping with known keys. A subclass annotates its fields; a value beside one is its default, or a `Field`."""

    fields: ClassVar[dict[str, FieldInfo]] = {}
    kinds: ClassVar[dict[str, Kind]]
    given: frozenset[str]
    """The keys that the data held."""

    def __init_subclass__(cls) -> None:
        inherited = {
            name: one for base in reversed(cls.__mro__[1:]) for name, one in vars(base).get("fields", {}).items()
        }
        own = (name for name in inspect.get_annotations(cls) if name not in ("fields", "given"))
        declared = ((name, vars(cls).get(name, FieldInfo())) for name in own)
        cls.fields = {
            **inherited,
            **{name: one if isinstance(one, FieldInfo) else FieldInfo(default=one) for name, one in declared},
        }

    if not TYPE_CHECKING:

        def __init__(self, given: frozenset[str] = frozenset(), **values: Any) -> None:
            for name, one in self.fields.items():
                object.__setattr__(self, name, values[name] if name in values else one.initial())
            object.__setattr__(self, "given", given or frozenset(values))

        def __setattr__(self, name: str, value: Any) -> None:
            raise AttributeError(f"{type(self).__name__} is read only")

    def replaced(self, **values: Any) -> Self:
        """A copy with other values."""
        same = {name: getattr(self, name) for name in self.fields}
        return type(self)(**{"given": self.given, **same, **values})

    def plain(self) -> dict[str, Any]:
        """The values by name, forms as mappings."""
        return {name: _plain(getattr(self, name)) for name in self.fields}

    @classmethod
    def read(cls, data: Any) -> Self:
        """The form of some data. Raises FormError with every error."""
        errors: list[Error] = []
        found: Self = _kind(cls).read(data, (), errors)
        if errors:
            raise FormError(errors)
        return found

    @classmethod
    def schema(cls) -> Schema:
        """The JSON Schema (draft 2020-12), with the forms that it holds under `$defs`."""
        definitions: Schema = {}
        own = _form_schema(cls, definitions)
        return deepcopy({"$defs": dict(sorted(definitions.items())), **own})


def _plain(value: Any) -> Any:
    if isinstance(value, Form):
        return value.plain()
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


def _kinds(form: type[Form]) -> dict[str, Kind]:
    """The types of a form's fields, with the limits of each `Field`."""
    if "kinds" not in vars(form):
        hints = get_type_hints(form, include_extras=True)
        form.kinds = {name: _limited(_kind(hints[name]), one.limits) for name, one in form.fields.items()}
    return form.kinds


def _form(form: type[Form]) -> Kind:
    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        if not isinstance(data, dict):
            errors.append(Error("mapping", at))
            return None
        kinds, before, values = _kinds(form), len(errors), {}
        for key, value in data.items():
            if key not in kinds:
                errors.append(Error("unknown", (*at, key)))
            elif value is not None:
                values[key] = kinds[key].read(value, (*at, key), errors)
        for name, one in form.fields.items():
            if one.required and name not in values:
                errors.append(Error("missing", (*at, name)))
        return form(given=frozenset(values), **values) if len(errors) == before else None  # type: ignore[call-arg]

    def schema(definitions: Schema) -> Schema:
        if form.__name__ not in definitions:
            definitions[form.__name__] = {}  # a form may hold itself
            definitions[form.__name__] = _form_schema(form, definitions)
        return {"$ref": f"#/$defs/{form.__name__}"}

    return Kind(read, schema)


def _form_schema(form: type[Form], definitions: Schema) -> Schema:
    properties = {}
    for name, kind in _kinds(form).items():
        one, inner = form.fields[name], {**kind.schema(definitions), **form.fields[name].more}
        about: Schema = {"description": one.description} if one.description else {}
        if one.default is not ...:
            about["default"] = _plain(one.default)
        if not one.required and inner.get("anyOf", [{}])[-1] != {"type": "null"}:
            inner = {"anyOf": [inner, {"type": "null"}]}
        properties[name] = {**about, **inner}
    required = [name for name, one in form.fields.items() if one.required]
    whole: Schema = {"type": "object", "properties": properties, "additionalProperties": False}
    return {"description": inspect.getdoc(form), **whole, **({"required": required} if required else {})}


_SCALARS: dict[Any, tuple[str, str, tuple[type, ...]]] = {
    str: ("text", "string", (str,)),
    bool: ("truth", "boolean", (bool,)),
    int: ("whole", "integer", (int,)),
    float: ("number", "number", (int, float)),
}
"""What is wanted, the name in the schema, the Python types."""


def _scalar(of: Any) -> Kind:
    wanted, name, types = _SCALARS[of]

    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        if not isinstance(data, types) or (isinstance(data, bool) and of is not bool):
            errors.append(Error(wanted, at))
        return data

    return Kind(read, lambda _: {"type": name})


def _literal(choices: tuple[Any, ...]) -> Kind:
    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        if not any(type(data) is type(one) and data == one for one in choices):
            errors.append(Error("choice", at, choices))
        return data

    name = _SCALARS[type(choices[0])][1]
    allowed: Schema = {"enum": [*choices]} if len(choices) > 1 else {"const": choices[0]}
    return Kind(read, lambda _: {**allowed, "type": name})


def _dict(keys: Kind, values: Kind) -> Kind:
    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        if not isinstance(data, dict):
            errors.append(Error("mapping", at))
            return None
        found = {}
        for key, value in data.items():
            name = keys.read(key, (*at, key, KEY), errors)
            found[name] = values.read(value, (*at, key), errors)
        return found

    def schema(definitions: Schema) -> Schema:
        inner = values.schema(definitions)
        pattern = keys.schema(definitions).get("pattern")
        return {
            "type": "object",
            **({"patternProperties": {pattern: inner}} if pattern else {"additionalProperties": inner or True}),
        }

    return Kind(read, schema)


def _list(items: Kind) -> Kind:
    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        if not isinstance(data, list):
            errors.append(Error("list", at))
            return None
        return [items.read(item, (*at, index), errors) for index, item in enumerate(data)]

    return Kind(read, lambda definitions: {"type": "array", "items": items.schema(definitions)})


def _union(members: list[Kind], may_be_none: bool) -> Kind:
    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        if data is None and may_be_none:
            return None
        tries: list[list[Error]] = []
        for member in members:
            tries.append([])
            found = member.read(data, at, tries[-1])
            if not tries[-1]:
                return found
        wanted = " or ".join(one.kind for found in tries for one in found[:1])
        errors += tries[0] if len(tries) == 1 else [Error(wanted, at)]
        return None

    def schema(definitions: Schema) -> Schema:
        found = [member.schema(definitions) for member in members]
        flat = [inner for one in found for inner in (one["anyOf"] if [*one] == ["anyOf"] else [one])]
        return {"anyOf": [*flat, *([{"type": "null"}] if may_be_none else [])]}

    return Kind(read, schema)


def _limited(kind: Kind, limits: Mapping[str, int]) -> Kind:
    """A type with the limits of a field."""
    if not limits:
        return kind

    def read(data: Any, at: Location, errors: list[Error]) -> Any:
        before = len(errors)
        value = kind.read(data, at, errors)
        if len(errors) == before:
            for name, limit in limits.items():
                size = value if name in ("ge", "le") else len(value)
                if size < limit if name in ("ge", "min_length") else size > limit:
                    errors.append(Error("limit", at, (name, limit)))
        return value

    def schema(definitions: Schema) -> Schema:
        whole = kind.schema(definitions)
        text = "Length" if whole.get("type") == "string" or _of_text(whole) else "Properties"
        names = {"min_length": f"min{text}", "max_length": f"max{text}", "ge": "minimum", "le": "maximum"}
        keys = {names[name]: limit for name, limit in limits.items()}
        if "anyOf" in whole:
            return {**whole, "anyOf": [{**whole["anyOf"][0], **keys}, *whole["anyOf"][1:]]}
        return {**whole, **keys}

    return Kind(read, schema)


def _of_text(schema: Schema) -> bool:
    return bool(schema.get("anyOf", [{}])[0].get("type") == "string")


def _added(kind: Kind, extra: Any) -> Kind:
    """A type with what `Annotated` adds to it."""
    if isinstance(extra, FieldInfo):
        inner = _limited(kind, extra.limits)
        return Kind(inner.read, lambda definitions: {**inner.schema(definitions), **extra.more})

    def refusing(change: Callable[[Any], Any], data: Any, at: Location, errors: list[Error]) -> tuple[bool, Any]:
        try:
            return True, change(data)
        except Refused as error:
            errors.append(Error("refused", at, str(error)))
            return False, None

    def check(data: Any, at: Location, errors: list[Error]) -> Any:
        return refusing(extra.read, data, at, errors)[1]

    def before(data: Any, at: Location, errors: list[Error]) -> Any:
        ok, changed = refusing(extra.change, data, at, errors)
        return kind.read(changed, at, errors) if ok else None

    def wrap(data: Any, at: Location, errors: list[Error]) -> Any:
        return refusing(lambda value: extra.read(value, lambda inner: kind.read(inner, at, errors)), data, at, errors)[
            1
        ]

    if isinstance(extra, Check):
        return Kind(check, lambda _: dict(extra.schema))

    def schema(definitions: Schema) -> Schema:
        if isinstance(extra.accepts, dict):
            return dict(extra.accepts)
        return (kind if extra.accepts is None else _kind(extra.accepts)).schema(definitions)

    return Kind(before if isinstance(extra, Before) else wrap, schema)


def _kind(annotation: Any) -> Kind:
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        kind = _kind(parts[0]) if not isinstance(parts[1], Check) else _ANY
        for extra in parts[1:]:
            kind = _added(kind, extra)
        return kind
    if origin is Literal:
        return _literal(parts)
    if origin is dict:
        return _dict(_kind(parts[0]), _kind(parts[1]))
    if origin is list:
        return _list(_kind(parts[0]))
    if origin in (Union, UnionType):
        return _union([_kind(one) for one in parts if one is not type(None)], type(None) in parts)
    if annotation in _SCALARS:
        return _scalar(annotation)
    if isinstance(annotation, type) and issubclass(annotation, Form):
        return _form(annotation)
    if annotation is Any:
        return _ANY
    raise TypeError(f"a form cannot hold {annotation}")


_ANY = Kind(lambda data, _, __: data, lambda _: {})
