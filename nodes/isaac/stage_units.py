"""Converts metres to stage units and back."""

from __future__ import annotations

from collections.abc import Mapping

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.types import DECIMALS, TYPES, Type
from nodes.data.promotion import common_type

TO_STAGE, TO_METERS = "Convert to stage units", "Convert to meters"


def _result_type(known: KnownTypes) -> Mapping[str, Type]:
    """The type of the value; integers, also in tuples and arrays, become double."""
    value = known["value"]
    if value is None:
        return {}
    return {"result": value if value.storage in DECIMALS else common_type([TYPES["double"], value])}


@node_type(
    "isaacsim.core.nodes.OgnIsaacScaleToFromStageUnit",
    version=1,
    volatile=True,
    inputs={
        "conversion": Attribute(
            "token", "which way", default=TO_STAGE, allowed_tokens=(TO_STAGE, TO_METERS), unit="stage units or m"
        ),
        "value": Attribute(("numerics",), "the length, or anything that grows with one, to convert"),
    },
    outputs={"result": Attribute(("numerics",), "the value in the other unit; of integers a double")},
    resolve=_result_type,
)
def scale_to_from_stage_unit(db: Database) -> None:
    """Divide metres by the stage's metres per unit, or multiply stage units by them."""
    conversion, value = db.inputs.conversion, db.inputs.value
    if conversion not in (TO_STAGE, TO_METERS):
        db.fail(f'input conversion is "{conversion}"; it is "{TO_STAGE}" or "{TO_METERS}"')
    unit = db.app.meters_per_unit
    db.outputs.result = value / unit if conversion == TO_STAGE else value * unit
