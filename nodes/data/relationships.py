"""Relationships of prims, read and written by name; the variants of a prim."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type

from .stage_prims import edited_layer, find_prim, only_target, path_of

NAME = Attribute("token", "name of the relationship", default="")
PRIM = Attribute("target", "the prim")


def _targets(db: Database, path: str) -> list[str] | None:
    """The targets of the relationship `name` of that prim; None, with a warning, for a missing prim."""
    prim = find_prim(db, path)
    if prim is None:
        return None
    name = _name(db)
    if not prim.HasRelationship(name):
        db.fail(f'{prim.GetPath()} has no relationship "{name}"')
    return [str(target) for target in prim.GetRelationship(name).GetTargets()]


def _name(db: Database) -> str:
    if not db.inputs.name:
        db.lack("input name is empty; give it the name of a relationship")
    return str(db.inputs.name)


@node_type(
    "omni.graph.nodes.ReadPrimRelationship",
    version=1,
    volatile=True,
    inputs={"name": NAME, "prim": PRIM},
    outputs={"value": Attribute("target", "what the relationship names")},
)
def read_prim_relationship(db: Database) -> bool:
    """Read a relationship; for a missing prim the output keeps its value."""
    targets = _targets(db, only_target(db, "prim", db.inputs.prim))
    if targets is None:
        return False
    db.outputs.value = targets
    return True


@node_type(
    "omni.graph.nodes.GetPrimRelationship",
    version=3,
    volatile=True,
    inputs={
        "name": NAME,
        "path": Attribute("token", "path of the prim where usePath is set", optional=True, role="prim"),
        "prim": Attribute("target", "the prim, unless usePath is set", optional=True),
        "usePath": Attribute("bool", "whether path names the prim instead of the input prim", default=False),
    },
    outputs={"paths": Attribute("token[]", "the paths that the relationship names")},
)
def get_prim_relationship(db: Database) -> bool:
    """Read a relationship as paths; ReadPrimRelationship is its successor.

    For a missing prim the output keeps its value.
    """
    targets = _targets(db, path_of(db, "path"))
    if targets is None:
        return False
    db.outputs.paths = targets
    return True


@node_type(
    "omni.graph.nodes.WritePrimRelationship",
    version=1,
    inputs={
        "execIn": Attribute("execution", "writes the relationship"),
        "layerIdentifier": Attribute(
            "token", "layer of the stage to write to; none means its edit target", default="", optional=True
        ),
        "name": NAME,
        "prim": PRIM,
        "usdWriteBack": Attribute(
            "bool", "whether the stage gets it; relationships are nowhere else, so it must be true", default=True
        ),
        "value": Attribute("target", "what it is to name"),
    },
    outputs={"execOut": Attribute("execution", "follows once it is written")},
)
def write_prim_relationship(db: Database) -> bool:
    """Write a relationship. A missing relationship is created; a missing prim is skipped."""
    prim = find_prim(db, only_target(db, "prim", db.inputs.prim))
    if prim is None:
        return False
    if not db.inputs.usdWriteBack:
        db.fail("input usdWriteBack is false, but relationships live on the stage only; set it to true")
    name = _name(db)
    with edited_layer(db):
        relationship = prim.GetRelationship(name) or prim.CreateRelationship(name)
        if not relationship.SetTargets(list(db.inputs.value)):
            db.fail(f"{prim.GetPath()}.{name} cannot name {list(db.inputs.value)}; give it absolute paths")
    db.fire("execOut")
    return True


SET_NAME = Attribute("token", "name of the variant set", default="")


def _variant_sets(db: Database) -> Any:
    """The prim's variant sets; None, with a warning, for a missing prim."""
    prim = find_prim(db, only_target(db, "prim", db.inputs.prim))
    return None if prim is None else prim.GetVariantSets()


def _variant_set(db: Database) -> Any:
    """The variant set that `variantSetName` names; None, with a warning, without a name or a prim.

    Fails the node if the prim has no set of that name.
    """
    sets, name = _variant_sets(db), db.inputs.variantSetName
    if not name:
        db.warn("variant-set-missing", "input variantSetName is empty; nothing is read")
        return None
    if sets is not None and not sets.HasVariantSet(name):
        db.fail(f'{db.inputs.prim[0]} has no variant set "{name}"; it has {", ".join(sets.GetNames()) or "none"}')
    return None if sets is None else sets.GetVariantSet(name)


@node_type(
    "omni.graph.nodes.HasVariantSet",
    version=2,
    volatile=True,
    inputs={"prim": PRIM, "variantSetName": SET_NAME},
    outputs={"exists": Attribute("bool", "whether the prim has that variant set")},
)
def has_variant_set(db: Database) -> None:
    """Give whether a prim has a variant set; false for a missing prim."""
    sets = _variant_sets(db)
    db.outputs.exists = sets is not None and bool(sets.HasVariantSet(db.inputs.variantSetName))


@node_type(
    "omni.graph.nodes.GetVariantSetNames",
    version=2,
    volatile=True,
    inputs={"prim": PRIM},
    outputs={"variantSetNames": Attribute("token[]", "its variant sets")},
)
def get_variant_set_names(db: Database) -> bool:
    """List the variant sets of a prim; for a missing prim the output keeps its value."""
    sets = _variant_sets(db)
    if sets is None:
        return False
    db.outputs.variantSetNames = list(sets.GetNames())
    return True


@node_type(
    "omni.graph.nodes.GetVariantNames",
    version=2,
    volatile=True,
    inputs={"prim": PRIM, "variantSetName": SET_NAME},
    outputs={"variantNames": Attribute("token[]", "the variants that can be chosen")},
)
def get_variant_names(db: Database) -> bool:
    """List the variants of a variant set; for a missing prim or name the output keeps its value."""
    chosen = _variant_set(db)
    if chosen is None:
        return False
    db.outputs.variantNames = list(chosen.GetVariantNames())
    return True


@node_type(
    "omni.graph.nodes.GetVariantSelection",
    version=2,
    volatile=True,
    inputs={"prim": PRIM, "variantSetName": SET_NAME},
    outputs={"variantName": Attribute("token", "the variant chosen; empty where none is")},
)
def get_variant_selection(db: Database) -> bool:
    """Read the selected variant of a variant set; for a missing prim or name the output keeps its value."""
    chosen = _variant_set(db)
    if chosen is None:
        return False
    db.outputs.variantName = chosen.GetVariantSelection()
    return True
