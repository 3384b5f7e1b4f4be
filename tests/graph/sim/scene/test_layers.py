import zipfile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph.base.errors import UserError
from graph.sim.scene.layer_text import nesting
from graph.sim.scene.layers import Checked, check_scene
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Usd


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#usda 1.0\n" + text)
    return path


def nested(depth):
    return "".join(f'def "p{i}"\n{{\n' for i in range(depth)) + "}\n" * depth


METRES = '(\n metersPerUnit = 1\n upAxis = "Z"\n)\n'


class Warnings(list):
    def __call__(self, code, where, message):
        self.append((code, message))


def test_a_missing_scene_is_one_clear_line(tmp_path):
    with pytest.raises(UserError, match=r"nope\.usda: no such scene file$"):
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


OUT = "@{out}:SDF_FORMAT_ARGS:a=b@"


@pytest.mark.parametrize(
    "arc",
    [
        f'def "W" (references = {OUT}) {{}}',
        f'def "W" (payload = {OUT}) {{}}',
        f"(\n subLayers = [{OUT}]\n)",
        f'def "W" (\n prepend variantSets = "v"\n)\n{{\n variantSet "v" = {{\n "a" (references = {OUT}) {{}}\n }}\n}}',
        f'def "W" (\n clips = {{\n dictionary default = {{\n asset[] assetPaths = [{OUT}]\n'
        ' string primPath = "/O"\n }\n }\n) {}',
        'def "W" (\n clips = {\n dictionary default = {\n string templateAssetPath = '
        '"{out}:SDF_FORMAT_ARGS:#=b"\n }\n }\n) {}',
        '(\n expressionVariables = {\n string X = "a=b"\n }\n)\n'
        'def "W" (references = @`"{out}:SDF_FORMAT_ARGS:${X}"`@) {}',
        'def "W" (references = @./link.usda:SDF_FORMAT_ARGS:a=b@) {}',
        'def "W" (references = @./nothing.usda:SDF_FORMAT_ARGS:broken@) {}',
    ],
    ids=["reference", "payload", "sublayer", "variant", "clip", "template", "expression", "link", "broken"],
)
def test_arguments_for_a_file_format_are_refused_whatever_file_is_before_them(tmp_path, arc):
    """USD takes them off before it looks for the file, so a path with them names another file than it seems to."""
    outside = write(tmp_path / "out.usda", nested(100_000))
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link.usda").symlink_to(outside)
    scene = write(tmp_path / "in" / "a.usda", arc.replace("{out}", str(outside)) + "\n")
    with pytest.raises(UserError, match=r"arguments for a file format are not read; take out :SDF_FORMAT_ARGS:"):
        open_stage(scene)


def test_arguments_are_refused_in_names_on_the_disk_and_of_the_scene(tmp_path):
    scene = write(tmp_path / "a.usda:SDF_FORMAT_ARGS:a=b.usda", "")
    with pytest.raises(UserError, match=r"USD reads :SDF_FORMAT_ARGS: in a name as arguments"):
        open_stage(scene)
    clip = clips("./a.usda:SDF_FORMAT#b.usda").replace("SDF_FORMAT#", "#")
    open_stage(write(tmp_path / "b.usda", clip))  # matches the file, whose name USD would take apart: left alone


def test_a_layer_that_was_not_checked_is_refused_when_the_stage_uses_it(tmp_path):
    """The second guard: whatever way USD found to a file, it must be one that was looked at, and the same file."""
    inner = write(tmp_path / "inner.usda", 'def "O" {}\n')
    scene = write(tmp_path / "a.usda", METRES + 'def "W" (references = @./inner.usda@</O>) {}\n')
    checked = check_scene(scene, [tmp_path], Warnings())
    stage = Usd.Stage.Open(str(scene))
    checked.confirm(stage)
    for files in ({str(scene): checked.files[str(scene)]}, {**checked.files, str(inner): (0, 0)}):
        with pytest.raises(UserError, match=r"inner\.usda: USD opened this file, which was not checked"):
            Checked([], files).confirm(stage)


def clips(template):
    inner = f'dictionary default = {{\n string templateAssetPath = "{template}"\n }}'
    return f'def "W" (\n clips = {{\n {inner}\n }}\n) {{}}\n'


def test_a_clip_template_that_leads_out_is_refused_whether_or_not_anything_matches(tmp_path):
    scene = write(tmp_path / "in" / "a.usda", clips("../nothing.###.usda"))
    with pytest.raises(UserError, match=r"\.\./nothing\.###\.usda leads out of .* Allow its folder with --allow DIR"):
        open_stage(scene)
    open_stage(scene, allow_roots=[tmp_path])


def test_a_clip_template_stands_for_numbers_alone(tmp_path):
    """What means something in a pattern of files is a character like any other."""
    write(tmp_path / "in" / "[ab].1.usda", 'def "O" {}\n')
    write(tmp_path / "in" / "a.1.usda", nested(300))
    open_stage(write(tmp_path / "in" / "a.usda", clips("./[ab].#.usda")))
    write(tmp_path / "in" / "[ab].1.usda", nested(300))
    with pytest.raises(UserError, match=r"\[ab\]\.1\.usda nests deeper"):
        open_stage(tmp_path / "in" / "a.usda")


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
    assert len(error.value.problems) == 3  # and the line that allows them


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


PIECES = st.lists(st.sampled_from([*'{}()[]"a/\n', '"a"', '"{"', *"'@#\\", '"""', "/*", "*/"]), max_size=60)


@given(PIECES)
def test_texts_with_nothing_but_short_strings_are_counted_like_any_other(pieces):
    """A comment with a quote behind it makes the same text one of the others, and changes no depth."""
    data = b"{}" * 60 + "".join(pieces).encode()
    assert nesting(data) == nesting(data + b"\n# '")


def test_closing_brackets_in_texts_hide_no_depth():
    assert nesting(b'{ "}" # }\n' * 300) == 300


def test_missing_assets_are_warnings_and_cycles_end(tmp_path):
    write(tmp_path / "b.usda", '(\n defaultPrim = "B"\n)\ndef "B" (references = @./a.usda@) {}\n')
    text = '(\n defaultPrim = "W"\n)\ndef "W" (references = @./b.usda@)\n{\n def "M" (payload = @./gone.usda@) {}\n}\n'
    warnings = Warnings()
    stage = open_stage(write(tmp_path / "a.usda", text), warn=warnings)
    assert stage.GetPrimAtPath("/W/M")
    assert ("usd-missing-asset", "./gone.usda does not exist; it is left out") in warnings
    assert any(code == "usd-composition" and "Cycle detected" in message for code, message in warnings)


def test_a_reference_within_the_same_file_asks_for_nothing(tmp_path):
    warnings = Warnings()
    text = METRES + 'def Cube "A" {}\ndef "B" (references = </A>) {}\n'
    stage = open_stage(write(tmp_path / "a.usda", text), warn=warnings)
    assert stage.GetPrimAtPath("/B").GetTypeName() == "Cube"
    assert warnings == []


def broken(folder):
    return write(folder / "broken.usda", 'def Xform "W"\n{{\n')


@pytest.mark.parametrize(
    "arc",
    [
        'def "W" (references = @./broken.usda@) {}',
        'def "W" (payload = @./broken.usda@) {}',
        "(subLayers = [@broken.usda@])",
    ],
)
def test_a_layer_that_is_there_and_broken_is_an_error_with_its_line_and_who_asks(tmp_path, arc):
    broken(tmp_path)
    with pytest.raises(
        UserError, match=r"^\S*broken\.usda:3:\d+: Expected .*\(\S*a\.usda asks for it\)\. Repair it"
    ) as error:
        open_stage(write(tmp_path / "a.usda", arc + "\n"))
    assert len(error.value.problems) == 1


@pytest.mark.parametrize("text", ["", "tickgraph: 1\n"])
def test_text_that_is_not_usd_is_called_so(tmp_path, text):
    (tmp_path / "other.usda").write_text(text)
    scene = write(tmp_path / "a.usda", 'def "W" (references = @./other.usda@) {}\n')
    with pytest.raises(UserError, match=r'it is not USD text, which starts with "#usda 1\.0" .*a\.usda asks for it'):
        open_stage(scene)


def test_what_is_not_a_usd_file_by_its_name_is_left_out_like_what_is_missing(tmp_path):
    (tmp_path / "model.obj").write_text("v 0 0 0\n")
    warnings = Warnings()
    assert open_stage(write(tmp_path / "a.usda", 'def "W" (references = @./model.obj@) {}\n'), warn=warnings)
    ((_, message),) = [one for one in warnings if one[0] == "usd-missing-asset"]
    assert "model.obj cannot be read as a USD layer" in message


VARIABLES = '(\n expressionVariables = {{ {} }}\n defaultPrim = "W"\n)\n'
BY_EXPRESSION = 'def "W" (references = @`"./${X}.usda"`@) {}\n'


def test_a_variable_expression_is_followed_as_usd_follows_it(tmp_path):
    write(tmp_path / "part.usda", '(\n defaultPrim = "P"\n)\ndef Sphere "P" {}\n')
    warnings = Warnings()
    scene = write(tmp_path / "a.usda", VARIABLES.format('string X = "part"') + BY_EXPRESSION)
    assert open_stage(scene, warn=warnings).GetPrimAtPath("/W").GetTypeName() == "Sphere"
    assert [one for one in warnings if one[0] != "units-assumed"] == []


def test_an_expression_that_leads_out_of_the_folder_is_refused(tmp_path):
    write(tmp_path / "out.usda", 'def "O" {}\n')
    scene = write(tmp_path / "in" / "a.usda", VARIABLES.format('string X = "../out"') + BY_EXPRESSION)
    with pytest.raises(UserError, match=r"out\.usda lies outside .*a\.usda asks for it"):
        open_stage(scene)


@pytest.mark.parametrize(
    ("above", "own", "led_to"),
    [
        ('string X = "one"', 'string X = "two"', "Cube"),
        ("", 'string X = "two"', "Sphere"),
        ('string X = "one"', "", "Cube"),
    ],
    ids=["the referencing layer wins", "a referenced layer has its own", "variables reach down"],
)
def test_variables_count_as_usd_counts_them(tmp_path, above, own, led_to):
    """So what is checked is what USD opens: the other one lies outside the folder."""
    folder = tmp_path / "in"
    for name, kind in (("one", "Cube"), ("two", "Sphere")):
        place = folder if kind == led_to else tmp_path
        write(place / f"{name}.usda", f'(\n defaultPrim = "P"\n)\ndef {kind} "P" {{}}\n')
        if place is tmp_path:
            (folder / f"{name}.usda").parent.mkdir(exist_ok=True)
            (folder / f"{name}.usda").symlink_to(place / f"{name}.usda")
    write(folder / "middle.usda", VARIABLES.format(own) + BY_EXPRESSION)
    scene = write(folder / "a.usda", VARIABLES.format(above) + 'def "W" (references = @./middle.usda@) {}\n')
    assert open_stage(scene).GetPrimAtPath("/W").GetTypeName() == led_to


def test_variables_of_a_sublayer_do_not_count(tmp_path):
    write(tmp_path / "under.usda", VARIABLES.format('string X = "part"') + BY_EXPRESSION)
    write(tmp_path / "part.usda", '(\n defaultPrim = "P"\n)\ndef Sphere "P" {}\n')
    warnings = Warnings()
    stage = open_stage(write(tmp_path / "a.usda", "(\n subLayers = [@under.usda@]\n)\n"), warn=warnings)
    assert stage.GetPrimAtPath("/W").GetTypeName() == ""
    said = './${X}.usda does not exist (the variable expression `"./${X}.usda"`; no expressionVariables give X)'
    assert ("usd-missing-asset", f"{said}; it is left out") in warnings


def test_one_layer_may_name_hundreds(tmp_path):
    for i in range(300):
        write(tmp_path / f"p{i}.usda", 'def "P" {}\n')
    arcs = ", ".join(f"@./p{i}.usda@</P>" for i in range(300))
    scene = write(tmp_path / "a.usda", VARIABLES.format('string X = "p"') + f'def "W" (references = [{arcs}]) {{}}\n')
    assert open_stage(scene).GetPrimAtPath("/W")


def test_a_sublayer_that_is_referenced_too_has_its_own_variables_there(tmp_path):
    write(tmp_path / "out.usda", '(\n defaultPrim = "P"\n)\ndef Sphere "P" {}\n')
    write(tmp_path / "in" / "under.usda", VARIABLES.format('string X = "../out"') + BY_EXPRESSION)
    text = "(\n subLayers = [@./under.usda@]\n)\n" + 'def "R" (references = @./under.usda@) {}\n'
    with pytest.raises(UserError, match=r"out\.usda lies outside"):
        open_stage(write(tmp_path / "in" / "a.usda", text))


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ('`"./${X.usda"`', "the variable expression `\"./${X.usda\"` is wrong: Missing ending '}' at character 7"),
        ("`${X}`", "the variable expression `${X}` gives 3, which is not a path"),
    ],
)
def test_an_expression_that_gives_no_path_is_reported_as_one(tmp_path, expression, said):
    warnings = Warnings()
    text = VARIABLES.format("int64 X = 3") + f'def "W" (references = @{expression}@) {{}}\n'
    open_stage(write(tmp_path / "a.usda", text), warn=warnings)
    assert ("usd-missing-asset", f"{said}; it is left out") in warnings


def test_expressions_do_not_hide_references_that_multiply(tmp_path):
    body = "".join(
        f'def "P{i}"\n{{\n def "A" (references = @`"${{X}}"`@</P{i + 1}>) {{}}\n'
        f' def "B" (references = @`"${{X}}"`@</P{i + 1}>) {{}}\n}}\n'
        for i in range(40)
    )
    scene = write(tmp_path / "a.usda", VARIABLES.format('string X = "./a.usda"') + body + 'def "P40" {}\n')
    with pytest.raises(UserError, match="its references multiply into "):
        open_stage(scene)


def test_variables_that_tell_ever_more_layers_apart_are_refused(tmp_path):
    """Each of 14 layers names all the others and a variable of its own: 2^13 sets of variables."""
    names = [f"l{i}" for i in range(14)]
    for name in names:
        arcs = ", ".join(f"@./{other}.usda@" for other in names if other != name)
        write(
            tmp_path / f"{name}.usda",
            VARIABLES.format(f'string {name} = "x"') + f'def "W" (references = [{arcs}]) {{}}\n',
        )
    with pytest.raises(UserError, match="its expression variables make its references multiply"):
        open_stage(tmp_path / "l0.usda")


@pytest.mark.parametrize("how", ["scene", "reference", "package", "packed"])
def test_text_of_more_than_64_mb_is_refused_before_it_is_read(tmp_path, how):
    with (tmp_path / "big.usda").open("wb") as stream:
        stream.write(b"#usda 1.0\n")
        stream.truncate(64 * 2**20 + 1)  # a hole: nothing is on the disk
    scene = tmp_path / "big.usda"
    if how == "reference":
        scene = write(tmp_path / "a.usda", 'def "W" (references = @./big.usda@) {}\n')
    elif how != "scene":
        scene = tmp_path / "b.usdz"
        packing = zipfile.ZIP_DEFLATED if how == "packed" else zipfile.ZIP_STORED
        with zipfile.ZipFile(scene, "w", packing) as package:
            package.write(tmp_path / "big.usda", "big.usda")
    by = r" \(\S*a\.usda asks for it\)" if how == "reference" else ""
    with pytest.raises(UserError, match=rf"is too much USD text{by}; save it as \.usdc; the limit is 67,108,864 bytes"):
        open_stage(scene)


def test_a_package_that_cannot_be_unpacked_is_one_line(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.usdz", "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("a.usda", "#usda 1.0\n" + "x" * 1000)
    data = bytearray((tmp_path / "a.usdz").read_bytes())
    data[40:44] = b"\xff\xff\xff\xff"
    (tmp_path / "a.usdz").write_bytes(data)
    with pytest.raises(UserError, match=r"a\.usdz cannot be read: "):
        open_stage(tmp_path / "a.usdz")


def outside_scene(tmp_path):
    """A scene whose reference, payload and sublayer lead to two folders beside its own, and a reference to nothing."""
    own, props, other = tmp_path / "own", tmp_path / "props" / "deep", tmp_path / "two words"
    for folder in (own, props, other):
        folder.mkdir(parents=True)
    (props / "p.usda").write_text('#usda 1.0\n(defaultPrim = "P")\ndef Cube "P"\n{\n}\n')
    (other / "q.usda").write_text('#usda 1.0\n(defaultPrim = "P")\ndef Sphere "P"\n{\n}\n')
    (other / "s.usda").write_text('#usda 1.0\ndef Cone "Below"\n{\n}\n')
    (own / "f.usda").write_text(
        '#usda 1.0\n(subLayers = [@../two words/s.usda@]\nmetersPerUnit = 1\nupAxis = "Z")\n'
        'def "A" (prepend references = @../props/deep/p.usda@)\n{\n}\n'
        'def "B" (prepend payload = @../two words/q.usda@)\n{\n}\n'
        'def "C" (prepend references = @../none/q.usda@)\n{\n}\n'
        'def Cube "Own"\n{\n}\n'
    )
    return own / "f.usda", props, other


def test_the_last_line_says_what_to_allow_and_it_does(tmp_path):
    import shlex

    from graph.base.errors import UserError
    from graph.sim.scene.stage import open_stage

    file, props, other = outside_scene(tmp_path)
    with pytest.raises(UserError) as refused:
        open_stage(file)
    line = str(refused.value.problems[-1])
    assert line == (
        f"to read what lies outside its folder: --allow {props} --allow '{other}'; to run without it: --skip-outside"
    )
    words = shlex.split(line.partition(": ")[2].partition(";")[0])
    # ../none is not there: it stays refused, and is named alone.
    with pytest.raises(UserError, match=r"none/q\.usda") as refused:
        open_stage(file, [file.parent, *words[1::2]])
    assert len(refused.value.problems) == 2
    stage = open_stage(file, [file.parent, *words[1::2]], skip_outside=True)
    assert [stage.GetPrimAtPath(path).GetTypeName() for path in ("/A", "/B", "/Below")] == ["Cube", "Sphere", "Cone"]


def test_the_line_to_allow_is_whole_however_long(tmp_path):
    from graph.base.errors import UserError
    from graph.sim.scene.stage import open_stage

    own = tmp_path / "own"
    own.mkdir()
    folders = [tmp_path / f"{n:02d}{'x' * 200}" for n in range(20)]
    for folder in folders:
        folder.mkdir()
        (folder / "p.usda").write_text("#usda 1.0\n")
    uses = "".join(f'def "P{n}" (prepend references = @{one}/p.usda@)\n{{\n}}\n' for n, one in enumerate(folders))
    (own / "f.usda").write_text(f"#usda 1.0\n{uses}")
    with pytest.raises(UserError) as refused:
        open_stage(own / "f.usda")
    line = str(refused.value.problems[-1])
    assert all(f"--allow {folder}" in line for folder in folders)


def test_what_lies_outside_can_be_left_out_each_with_a_line(tmp_path):
    from graph.sim.scene.stage import open_stage

    file, props, other = outside_scene(tmp_path)
    told = []
    stage = open_stage(file, warn=lambda *one: told.append(one), skip_outside=True)
    assert [str(stage.GetPrimAtPath(path).GetTypeName()) for path in ("/A", "/B", "/C", "/Own")] == ["", "", "", "Cube"]
    assert not stage.GetPrimAtPath("/Below")
    assert all(one.anonymous or one.realPath == str(file) for one in stage.GetUsedLayers())
    assert [code for code, _, _ in told] == ["usd-outside-skipped"] * 4
    assert {where for _, where, _ in told} == {
        str(props / "p.usda"), str(other / "q.usda"), str(other / "s.usda"), "../none/q.usda",
    }  # fmt: skip


def test_value_clips_outside_are_refused_all_the_same(tmp_path):
    from graph.base.errors import UserError
    from graph.sim.scene.stage import open_stage

    file, props, _ = outside_scene(tmp_path)
    clips = f'{{ dictionary default = {{ asset[] assetPaths = [@{props}/p.usda@]\nstring primPath = "/P" }} }}'
    file.write_text(f'#usda 1.0\ndef "A" (clips = {clips})\n{{\n}}\n')
    with pytest.raises(UserError, match="lies outside"):
        open_stage(file, skip_outside=True)


def test_an_app_takes_allowed_folders_and_says_which_graphs_it_does_not_run(tmp_path):
    from graph.sim import App

    file, _, _ = outside_scene(tmp_path)
    file.write_text(file.read_text() + 'def OmniGraph "G"\n{\n}\n')
    with App(str(file), allow=[tmp_path]) as app:
        assert app.stage.GetPrimAtPath("/A").GetTypeName() == "Cube"
        assert [(one.code, one.message) for one in app.warnings if one.code == "graphs-not-run"] == [
            ("graphs-not-run", f"its graphs do not run in App(stage=...): /G; App.from_file({str(file)!r}) runs them")
        ]
    with App.from_file(file, allow=[str(tmp_path)]) as app:
        assert app.stage.GetPrimAtPath("/B").GetTypeName() == "Sphere"
