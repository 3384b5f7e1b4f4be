import zipfile

import pytest

from graph.errors import UserError
from graph.sim.scene.layers import nesting
from graph.sim.scene.stage import open_stage


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#usda 1.0\n" + text)
    return path


def nested(depth):
    return "".join(f'def "p{i}"\n{{\n' for i in range(depth)) + "}\n" * depth


class Warnings(list):
    def __call__(self, code, where, message):
        self.append((code, message))


def test_a_missing_scene_is_one_clear_line(tmp_path):
    with pytest.raises(UserError, match=r"nope\.usda: no such scene file\.$"):
        open_stage(tmp_path / "nope.usda")


def test_a_file_that_is_not_usd_is_refused(tmp_path):
    (tmp_path / "a.txt").write_text("hello")
    (tmp_path / "b.usda").write_text("hello")
    with pytest.raises(UserError, match=r"not a USD file; its name must end in"):
        open_stage(tmp_path / "a.txt")
    with pytest.raises(UserError, match=r"b\.usda"):
        open_stage(tmp_path / "b.usda")


def test_a_syntax_error_names_file_line_and_column(tmp_path):
    with pytest.raises(UserError, match=r"a\.usda:3:\d+: Expected"):
        open_stage(write(tmp_path / "a.usda", 'def Xform "W"\n{{\n'))


@pytest.mark.parametrize(
    "arc",
    [
        'def "W" (references = @../out.usda@) {}',
        'def "W" (payload = @../out.usda@) {}',
        "(\n subLayers = [@../out.usda@]\n)",
        'def "W" (\n variants = {\n string v = "b"\n }\n prepend variantSets = "v"\n)\n{\n variantSet "v" = {\n'
        ' "a" (references = @../out.usda@) {}\n "b" {}\n }\n}',
        'def "W" (\n clips = {\n dictionary default = {\n asset[] assetPaths = [@../out.usda@]\n'
        ' string primPath = "/O"\n }\n }\n) {}',
        'def "W" (\n clips = {\n dictionary default = {\n string templateAssetPath = "../ou#.usda"\n }\n }\n) {}',
        'def "W" (references = @./inner.usda@) {}',
        'def "W" (references = @./link.usda@) {}',
    ],
    ids=[
        "reference",
        "payload",
        "sublayer",
        "unselected variant",
        "clip",
        "clip template",
        "two hops",
        "symbolic link",
    ],
)
def test_whatever_leads_out_of_the_folder_is_refused(tmp_path, arc):
    outside = write(tmp_path / "out.usda", 'def "O" {}\n')
    write(tmp_path / "in" / "inner.usda", 'def "I" (references = @../out.usda@) {}\n')
    (tmp_path / "in" / "link.usda").symlink_to(outside)
    if "ou#" in arc:
        outside.rename(tmp_path / "ou1.usda")
    scene = write(tmp_path / "in" / "a.usda", arc + "\n")
    with pytest.raises(UserError, match=r"lies outside .*allow its folder with --allow DIR"):
        open_stage(scene)
    open_stage(scene, allow_roots=[tmp_path])


def test_an_absolute_path_out_of_the_folder_is_refused(tmp_path):
    outside = write(tmp_path / "out.usda", 'def "O" {}\n')
    scene = write(tmp_path / "in" / "a.usda", f'def "W" (references = @{outside}@) {{}}\n')
    with pytest.raises(UserError, match=r"out\.usda lies outside"):
        open_stage(scene)


def test_every_file_outside_is_named_at_once(tmp_path):
    for name in ("x", "y"):
        write(tmp_path / f"{name}.usda", 'def "O" {}\n')
    text = 'def "A" (references = @../x.usda@) {}\ndef "B" (references = @../y.usda@) {}\n'
    with pytest.raises(UserError) as error:
        open_stage(write(tmp_path / "in" / "a.usda", text))
    assert len(error.value.problems) == 2


def test_a_layer_nested_256_deep_opens_and_one_deeper_is_refused(tmp_path):
    assert open_stage(write(tmp_path / "a.usda", nested(256)))
    with pytest.raises(UserError, match="nests deeper than 256 levels; USD cannot read it safely"):
        open_stage(write(tmp_path / "b.usda", nested(257)))
    with pytest.raises(UserError, match="nests deeper than 256 levels"):
        open_stage(write(tmp_path / "c.usd", nested(100_000)))


def test_a_deep_layer_is_refused_wherever_it_hides(tmp_path):
    write(tmp_path / "deep.usda", nested(300))
    with pytest.raises(UserError, match=r"deep\.usda nests deeper than 256 levels \(.*a\.usda asks for it\)"):
        open_stage(write(tmp_path / "a.usda", 'def "W" (references = @./deep.usda@) {}\n'))
    with zipfile.ZipFile(tmp_path / "b.usdz", "w") as package:
        package.write(tmp_path / "deep.usda", "deep.usda")
    with pytest.raises(UserError, match=r"b\.usdz nests deeper than 256 levels"):
        open_stage(tmp_path / "b.usdz")


def test_brackets_in_texts_comments_and_asset_paths_do_not_count():
    data = b'"{{{" \'((\' """[\n[""" # {{{\n @{{@ @@@[[[@@@ /* (( */ { [ ( ) ] }' * 100
    assert nesting(data) == 3


def test_closing_brackets_in_texts_hide_no_depth():
    assert nesting(b'{ "}" # }\n' * 300) == 300


def test_missing_assets_are_warnings_and_cycles_end(tmp_path):
    write(tmp_path / "b.usda", '(\n defaultPrim = "B"\n)\ndef "B" (references = @./a.usda@) {}\n')
    text = '(\n defaultPrim = "W"\n)\ndef "W" (references = @./b.usda@)\n{\n def "M" (payload = @./gone.usda@) {}\n}\n'
    warnings = Warnings()
    stage = open_stage(write(tmp_path / "a.usda", text), warn=warnings)
    assert stage.GetPrimAtPath("/W/M")
    assert ("usd-missing-asset", "./gone.usda does not exist; it is left out.") in warnings
    assert any(code == "usd-composition" and "Cycle detected" in message for code, message in warnings)


def test_a_reference_within_the_same_file_asks_for_nothing(tmp_path):
    warnings = Warnings()
    stage = open_stage(write(tmp_path / "a.usda", 'def Cube "A" {}\ndef "B" (references = </A>) {}\n'), warn=warnings)
    assert stage.GetPrimAtPath("/B").GetTypeName() == "Cube"
    assert warnings == []
