"""The count of composed prims against USD's own, and at the limit."""

import pytest

from graph.base import limits
from graph.base.errors import UserError
from graph.sim.scene.composed_size import too_many_prims
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Sdf, Usd
from tests.support.costs import within

WHEEL = 'def "Wheel" {\n def "Rim" {}\n def "Tire" { def "Tread" {} }\n}\n'
SELECTED = 'variants = {\n string size = "big"\n }\n'
SCENES = {
    "nothing composed": 'def "A" { def "B" {} }\ndef "C" {}\n',
    "references": WHEEL + 'def "Car" {\n def "L" (references = </Wheel>) {}\n def "R" (references = </Wheel>) {}\n}\n',
    "references of references": WHEEL
    + 'def "Axle" {\n def "L" (references = </Wheel>) {}\n def "R" (references = </Wheel>) {}\n}\n'
    + 'def "Car" {\n def "F" (references = </Axle>) {}\n def "B" (references = </Axle>) {}\n}\n',
    "children that merge": WHEEL
    + 'def "Other" { def "Rim" {}\n def "Hub" {} }\n'
    + 'def "Both" (references = [</Wheel>, </Other>]) { over "Tire" {} }\n',
    "a reference into what is referenced": WHEEL
    + 'def "Copy" (references = </Wheel>) {}\ndef "Part" (references = </Copy/Tire>) {}\n',
    "inherits and specializes": WHEEL
    + 'def "I" (inherits = </Wheel>) {}\ndef "S" (specializes = </Wheel>) { def "Own" {} }\n',
    "a selected variant": f'def "V" (\n {SELECTED}prepend variantSets = "size"\n)\n{{\n'
    ' variantSet "size" = {\n "big" { def "X" {}\n def "Y" {} }\n "small" { def "Z" {} }\n }\n}\n',
    "payload and instances": WHEEL
    + "".join(f'def "{name}" (\n instanceable = true\n payload = </Wheel>\n) {{}}\n' for name in "AB"),
    "another file": 'def "A" (references = @./part.usda@) {}\ndef "B" (references = @./part.usda@</P/Q>) {}\n',
    "a sublayer": '(\n subLayers = [@./part.usda@]\n)\nover "P" { def "More" {} }\n',
}


def composed(file):
    """How many prims USD makes, the pseudo-root included, instances walked into."""
    stage = Usd.Stage.Open(str(file))
    every = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)
    return sum(1 for _ in Usd.PrimRange(stage.GetPseudoRoot(), every))


def written(path, text):
    """A text layer; braces may stand together, which USD's grammar does not take."""
    path.write_text("#usda 1.0\n" + text.replace("{", "{\n").replace("}", "\n}\n"))
    return Sdf.Layer.FindOrOpen(str(path))


@pytest.mark.parametrize("case", SCENES)
def test_the_count_is_what_usd_composes(tmp_path, case):
    part = written(tmp_path / "part.usda", '(\n defaultPrim = "P"\n)\ndef "P" { def "Q" { def "R" {} } }\n')
    layer = written(tmp_path / "a.usda", SCENES[case])
    count = composed(tmp_path / "a.usda")
    with limits.raised({"usd.prims": count}):
        assert too_many_prims(layer) == 0
    with limits.raised({"usd.prims": count - 1}):
        assert too_many_prims(layer) == count
    del part  # held until here: layers that are not open count nothing


def test_variants_that_nobody_selects_count_each(tmp_path):
    """Another layer may select any: the root, V, X, Y and Z."""
    layer = written(tmp_path / "a.usda", SCENES["a selected variant"].replace(SELECTED, ""))
    with limits.raised({"usd.prims": 4}):
        assert too_many_prims(layer) == 5


@pytest.mark.parametrize("instanceable", ["", "instanceable = true\n "])
def test_eight_times_ten_references_are_refused_at_once(tmp_path, instanceable):
    """10^8 prims, shared or not: a traversal of the scene would meet each."""
    lines = ['def "A0" {\n}\n']
    for level in range(1, 9):
        inner = "".join(f'def "c{i}" (\n {instanceable}references = </A{level - 1}>\n) {{\n}}\n' for i in range(10))
        lines.append(f'def "A{level}" {{\n{inner}}}\n')
    (tmp_path / "a.usda").write_text("#usda 1.0\n" + "".join(lines))
    refused = r"its references multiply into [\d,]+ prims or more; .*--limit usd\.prims=N"
    with within(5), pytest.raises(UserError, match=refused):
        open_stage(tmp_path / "a.usda")


def test_many_variants_of_one_model_are_not_multitude(tmp_path):
    """As official assets are: 40 variants, each a reference to the same 1,000 prims, in 30 copies of the model."""
    parts = "".join(f'def "p{i}" {{\n}}\n' for i in range(1000))
    variants = "".join(f'"v{i}" (references = </Parts>) {{\n}}\n' for i in range(40))
    model = f'variantSet "v" = {{\n{variants}}}\n'
    text = f'def "Parts" {{\n{parts}}}\ndef "Model" (\n prepend variantSets = "v"\n)\n{{\n{model}}}\n'
    copies = "".join(f'def "m{i}" (references = </Model>) {{\n}}\n' for i in range(30))
    (tmp_path / "a.usda").write_text("#usda 1.0\n" + text + copies)
    stage = open_stage(tmp_path / "a.usda")
    assert len(list(stage.Traverse())) == 1001 + 1 + 30  # no variant is selected
