"""OmniGraph's `Type` and `AttributeType`: OGN's types as base, role, tuple count and array depth."""

from __future__ import annotations

from functools import cache
from typing import Any

from graph.values.types import GROUPS, TYPES
from graph.values.types import Type as OgnType

from .enums import AttributeRole, BaseDataType

_BASES = {
    **{name.lower(): base for name, base in BaseDataType.__members__.items()},
    "string": BaseDataType.UCHAR,
    "target": BaseDataType.RELATIONSHIP,
    "bundle": BaseDataType.RELATIONSHIP,
    "execution": BaseDataType.UINT,
}
_ROLES = {
    "": AttributeRole.NONE,
    "vector": AttributeRole.VECTOR,
    "normal": AttributeRole.NORMAL,
    "point": AttributeRole.POSITION,
    "color": AttributeRole.COLOR,
    "texcoord": AttributeRole.TEXCOORD,
    "quat": AttributeRole.QUATERNION,
    "frame": AttributeRole.FRAME,
    "timecode": AttributeRole.TIMECODE,
    "matrix": AttributeRole.MATRIX,
    "objectId": AttributeRole.OBJECT_ID,
    "path": AttributeRole.PATH,
}
_STORAGE_ROLES = {
    "string": AttributeRole.TEXT,
    "target": AttributeRole.TARGET,
    "bundle": AttributeRole.BUNDLE,
    "execution": AttributeRole.EXECUTION,
}
_SIZES = {1: 1, 2: 1, 3: 4, 4: 4, 5: 8, 6: 8, 7: 2, 8: 4, 9: 8, 10: 8, 11: 8}


class Type:
    """A type as OmniGraph describes it; equal if all four parts are."""

    def __init__(
        self, base_type: Any, tuple_count: int = 1, array_depth: int = 0, role: Any = AttributeRole.NONE
    ) -> None:
        self.base_type, self.tuple_count = BaseDataType(base_type), int(tuple_count)
        self.array_depth, self.role = int(array_depth), AttributeRole(role)

    def _key(self) -> tuple[int, int, int, int]:
        return int(self.base_type), self.tuple_count, self.array_depth, int(self.role)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Type) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        return f"<omni.graph.core.Type {self}>"

    def __str__(self) -> str:
        return self.get_ogn_type_name()

    @property
    def name(self) -> str:
        """The OGN name, which edits read."""
        return self.get_ogn_type_name()

    def get_ogn_type_name(self) -> str:
        """`pointd[3][]`; "unknown" if OGN has no such type."""
        found = _by_key().get(self._key())
        return "unknown" if found is None else found

    def get_type_name(self) -> str:
        """The type in OmniGraph's other spelling: `pointd[3][]` as `double3[] (point)`."""
        role = "" if self.role is AttributeRole.NONE else f" ({self.get_role_name()})"
        count = str(self.tuple_count) if self.tuple_count > 1 else ""
        return f"{self.get_base_type_name()}{count}{'[]' * self.array_depth}{role}"

    def get_base_type_name(self) -> str:
        """The name of the base."""
        return self.base_type.name.lower()

    def get_role_name(self) -> str:
        """The name of the role."""
        return self.role.name.lower()

    def is_matrix_type(self) -> bool:
        """Whether it is a matrix."""
        return self.role in (AttributeRole.MATRIX, AttributeRole.FRAME, AttributeRole.TRANSFORM)

    def is_compatible_raw_data(self, type_to_compare: Type) -> bool:
        """Whether the memory of both is the same."""
        return self._key()[:3] == type_to_compare._key()[:3]


UNKNOWN = Type(BaseDataType.UNKNOWN, 0, 0, AttributeRole.UNKNOWN)


@cache
def _by_key() -> dict[tuple[int, int, int, int], str]:
    return {type_of(one)._key(): name for name, one in reversed(TYPES.items())}


def type_of(type_: OgnType | None) -> Type:
    """A type of ours as OmniGraph describes it; None is an unresolved one."""
    if type_ is None:
        return UNKNOWN
    role = _STORAGE_ROLES.get(type_.storage, _ROLES[type_.role]) if not type_.role else _ROLES[type_.role]
    depth = int(type_.array) + (type_.storage == "string")
    return Type(_BASES[type_.storage], type_.count * (type_.count if type_.square else 1), depth, role)


class AttributeType:
    """Static helpers about types."""

    @staticmethod
    def type_from_ogn_type_name(ogn_type_name: str) -> Type:
        """The type with that OGN name; an unknown one never raises."""
        return type_of(TYPES.get(str(ogn_type_name)))

    @staticmethod
    def type_from_sdf_type_name(sdf_type_name: Any) -> Type:
        """The type of an attribute with that Sdf type."""
        from graph.usd_files.values import ogn_name

        return type_of(TYPES.get(ogn_name(str(sdf_type_name)) or ""))

    @staticmethod
    def sdf_type_name_from_type(type: Type) -> str | None:
        """The Sdf type of a type, or None."""
        from graph.usd_files.values import sdf_name

        found = TYPES.get(type.get_ogn_type_name())
        return None if found is None else sdf_name(found)

    @staticmethod
    def base_data_size(type: Type) -> int:
        """Bytes of one component."""
        return _SIZES.get(int(type.base_type), 0)

    @staticmethod
    def get_unions() -> dict[str, list[str]]:
        """The names of type groups, with their members."""
        return {name: [str(one) for one in members] for name, members in GROUPS.items()}

    @staticmethod
    def is_legal_ogn_type(type: Type) -> bool:
        """Whether OGN has the type."""
        return type.get_ogn_type_name() != "unknown"
