"""Dataclasses that cost less at import: only `__init__` is generated as text, the other methods are closures.

Used as `dataclasses.dataclass` with `frozen`, `slots`, `eq`, `repr` and `kw_only`; `dataclasses.replace`, `fields` and
`asdict` work on them. A command imports more than a hundred of them, and the standard ones cost 1 ms each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
    from dataclasses import field as field
else:
    import dataclasses as _standard
    from dataclasses import MISSING, Field, FrozenInstanceError
    from dataclasses import field as field
    from inspect import get_annotations
    from operator import attrgetter
    from reprlib import recursive_repr
    from types import SimpleNamespace

    _BEGIN = object()
    """Stands for the default of a field whose value a function makes."""

    def dataclass(cls: Any = None, /, **options: Any) -> Any:
        """The class with fields for its annotations, see above; with options, a decorator that gives it."""
        if cls is None:
            return lambda plain: _completed(plain, **options)
        return _completed(cls)

    def _completed(
        cls: Any,
        *,
        frozen: bool = False,
        slots: bool = False,
        eq: bool = True,
        repr: bool = True,
        kw_only: bool = False,
    ) -> Any:
        own, fields = _fields_of(cls, kw_only)
        members = dict(cls.__dict__)
        for name in own:
            default = fields[name].default
            if default is MISSING or slots:
                members.pop(name, None)
            else:
                members[name] = default
        members["__dataclass_fields__"] = fields
        members["__dataclass_params__"] = SimpleNamespace(frozen=frozen, eq=eq, order=False, repr=repr, init=True)
        members["__match_args__"] = tuple(name for name, one in fields.items() if one.init and not one.kw_only)
        members["__init__"] = _init(cls, fields, frozen)
        if repr:
            members.setdefault("__repr__", _repr([name for name, one in fields.items() if one.repr]))
        if eq:
            values = _values([name for name, one in fields.items() if one.compare])
            members.setdefault("__eq__", _equal(values))
            if members.get("__hash__") is None:  # a class that defines only __eq__ has None
                members["__hash__"] = _hash(values) if frozen else None
        if frozen:
            members["__setattr__"], members["__delattr__"] = _locked(fields, "assign to"), _locked(fields, "delete")
        if slots:
            taken = {name for base in cls.__mro__[1:] for name in getattr(base, "__slots__", ())}
            members["__slots__"] = tuple(name for name in own if name not in taken)
            if frozen:
                members.setdefault("__getstate__", _state)
                members.setdefault("__setstate__", _restore)
            members.pop("__dict__", None)
            members.pop("__weakref__", None)
            made = type(cls)(cls.__name__, cls.__bases__, members)
            made.__qualname__ = cls.__qualname__
            return made
        for name, member in members.items():
            if cls.__dict__.get(name, MISSING) is not member:
                setattr(cls, name, member)
        for name in own:
            if name in cls.__dict__ and name not in members:
                delattr(cls, name)
        return cls

    def _fields_of(cls: Any, kw_only: bool) -> tuple[list[str], dict[str, Any]]:
        """The names of the class's own fields, and all fields by name, those of its bases first."""
        fields: dict[str, Any] = {}
        for base in reversed(cls.__mro__[1:]):
            fields.update(getattr(base, "__dataclass_fields__", ()))
        own = []
        for name, annotation in get_annotations(cls).items():
            if "ClassVar" in str(annotation).partition("[")[0]:
                continue
            default = cls.__dict__.get(name, MISSING)
            one = default if isinstance(default, Field) else field(default=default)
            if one.default.__class__.__hash__ is None:
                raise ValueError(f"mutable default {one.default.__class__} for field {name}: use default_factory")
            one.name, one.type, one._field_type = name, annotation, _standard._FIELD
            one.kw_only = kw_only if one.kw_only is MISSING else one.kw_only
            fields[name] = one
            own.append(name)
        return own, fields

    def _init(cls: Any, fields: dict[str, Any], frozen: bool) -> Any:
        """`__init__`, made from text as the standard one is: nothing else is as fast to call."""
        scope: dict[str, Any] = {"_begin": _BEGIN, "_set": object.__setattr__}
        plain, named, lines = ["self"], [], []
        for name, one in fields.items():
            value = name
            if one.default_factory is not MISSING:
                scope[f"_make_{name}"] = one.default_factory
                value = f"_make_{name}() if {name} is _begin else {name}" if one.init else f"_make_{name}()"
                default = "=_begin"
            elif one.default is not MISSING:
                scope[f"_default_{name}"] = one.default
                value = name if one.init else f"_default_{name}"
                default = f"=_default_{name}"
            elif not one.init:
                continue
            else:
                default = ""
            if one.init:
                (named if one.kw_only else plain).append(name + default)
            lines.append(f"_set(self, {name!r}, {value})" if frozen else f"self.{name} = {value}")
        if hasattr(cls, "__post_init__"):
            lines.append("self.__post_init__()")
        arguments = [*plain, *(["*", *named] if named else [])]
        body = "\n ".join(lines or ["pass"])
        exec(f"def __init__({', '.join(arguments)}):\n {body}", scope)
        made = scope["__init__"]
        made.__qualname__ = f"{cls.__qualname__}.__init__"
        made.__module__ = cls.__module__
        return made

    def _values(names: list[str]) -> Any:
        """Instance -> the tuple of its values of these names."""
        if len(names) > 1:
            return attrgetter(*names)
        if names:
            only = attrgetter(names[0])
            return lambda self: (only(self),)
        return lambda self: ()

    def _equal(values: Any) -> Any:
        def equal(self: Any, other: Any) -> Any:
            return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

        return equal

    def _hash(values: Any) -> Any:
        def hashed(self: Any) -> int:
            return hash(values(self))

        return hashed

    def _repr(names: list[str]) -> Any:
        @recursive_repr()
        def text(self: Any) -> str:
            shown = ", ".join([f"{name}={getattr(self, name)!r}" for name in names])
            return f"{self.__class__.__qualname__}({shown})"

        return text

    def _locked(fields: dict[str, Any], what: str) -> Any:
        def refuse(self: Any, name: str, *value: Any) -> None:
            if "__dataclass_fields__" in type(self).__dict__ or name in fields:
                raise FrozenInstanceError(f"cannot {what} field {name!r}")
            (object.__setattr__ if value else object.__delattr__)(self, name, *value)

        return refuse

    def _state(self: Any) -> list[Any]:
        return [getattr(self, name) for name in self.__dataclass_fields__]

    def _restore(self: Any, state: list[Any]) -> None:
        for name, value in zip(self.__dataclass_fields__, state, strict=True):
            object.__setattr__(self, name, value)
