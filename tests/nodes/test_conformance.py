"""Every registered type against the facts table: names, versions, types, defaults, flags."""

import json

import pytest

from graph import UNSET, Attribute
from graph.node import registry
from graph.values.types import TYPES
from tests.support.places import LIBRARY_FACTS
from tests.support.without_wing import MISSING

FACTS = json.loads((LIBRARY_FACTS / "node_attributes.json").read_text())
DEVIATIONS = {
    type_id: reasons
    for type_id, reasons in json.loads((LIBRARY_FACTS / "deviations.json").read_text()).items()
    if type_id not in MISSING
}
ALL = registry.all()
LISTED = [one for one in ALL if one.id in FACTS]


def declared(node_type):
    """Prefixed name -> attribute."""
    groups = {"inputs": node_type.inputs, "outputs": node_type.outputs, "state": node_type.state}
    return {f"{prefix}:{name}": attribute for prefix, group in groups.items() for name, attribute in group.items()}


def expected(node_type):
    facts = FACTS.get(node_type.id, {})
    return {
        f"{prefix}:{name}": fact
        for prefix in ("inputs", "outputs", "state")
        for name, fact in facts.get(prefix, {}).items()
    }


def described(attribute: Attribute):
    """What the facts table says about an attribute, read from its declaration."""
    kind = attribute.type if isinstance(attribute.type, str) else list(attribute.type)
    default = None if attribute.default is UNSET else attribute.default
    found = {"type": kind, "default": "nan" if default != default else default}
    flags = {
        "optional": attribute.optional,
        "literalOnly": attribute.literal_only,
        "outputOnly": attribute.output_only,
        "deprecated": bool(attribute.deprecated),
        "allowedTokens": list(attribute.allowed_tokens),
    }
    return found | {name: flag for name, flag in flags.items() if flag}


@pytest.mark.parametrize("node_type", LISTED, ids=lambda one: one.id)
def test_a_type_has_the_attributes_types_and_defaults_of_the_original(node_type):
    allowed = DEVIATIONS.get(node_type.id, {})
    found = {name: described(one) for name, one in declared(node_type).items() if name not in allowed}
    assert found == {name: fact for name, fact in expected(node_type).items() if name not in allowed}
    assert node_type.version == FACTS[node_type.id]["version"]


def test_an_original_missing_in_the_table_says_where_its_attributes_are_documented():
    """A node of one's own has a namespace of its own, and no original."""
    more = {one.id for one in ALL if one.id.startswith(("omni.", "isaacsim."))} - set(FACTS)
    assert more == {type_id for type_id, reasons in DEVIATIONS.items() if "source" in reasons}


def test_every_listed_deviation_is_real_and_says_why():
    for type_id, attributes in DEVIATIONS.items():
        node_type = registry.get(type_id)
        for name, reason in attributes.items():
            assert len(reason) > 20
            if name == "source":
                continue
            ours, theirs = declared(node_type).get(name), expected(node_type).get(name)
            assert ours is None or theirs is None or described(ours) != theirs, f"{type_id} {name} does not deviate"


@pytest.mark.parametrize("node_type", LISTED, ids=lambda one: one.id)
def test_types_that_files_extend_with_attributes_declare_it(node_type):
    dynamic = {*node_type.dynamic_inputs, *node_type.dynamic_outputs}
    assert bool(dynamic) == bool(FACTS[node_type.id].get("dynamic"))


@pytest.mark.parametrize("node_type", ALL, ids=lambda one: one.id)
def test_a_type_and_all_its_attributes_are_documented(node_type):
    assert len(node_type.doc.splitlines()[0]) > 10
    attributes = {**declared(node_type), **node_type.dynamic_inputs, **node_type.dynamic_outputs}
    for name, attribute in attributes.items():
        assert len(attribute.doc) > 5, name


PHYSICAL = ("time", "duration", "distance", "radius", "speed", "velocity", "acceleration", "translation", "position")
NO_UNIT = ("output", "reset", "use", "radialVelocityMSData", "distanceData", "velocityData", "timestampData")


@pytest.mark.parametrize("node_type", ALL, ids=lambda one: one.id)
def test_a_physical_number_says_its_unit(node_type):
    for full, attribute in declared(node_type).items():
        name = full.partition(":")[2]
        numeric = attribute.type in TYPES and TYPES[attribute.type].storage in ("float", "double")
        physical = any(word in name.lower() for word in PHYSICAL)
        if numeric and physical and not name.startswith(NO_UNIT):
            assert attribute.unit, f"{node_type.id} {full} has no unit"


def test_constants_of_every_listed_kind_are_there():
    found = sum(one.short_name.startswith("Constant") for one in LISTED)
    assert found == sum(".Constant" in name for name in FACTS) == 54
