import pytest

from graph.base.errors import UserError
from graph.files import load


@pytest.fixture
def folder(tmp_path, monkeypatch):
    home = tmp_path / "home"
    (home / "scenes").mkdir(parents=True)
    (home / "scenes" / "yard.usda").write_text("#usda 1.0\n")
    (home / "robot.xml").write_text("<mujoco/>")
    (home / "lidar.json").write_text("{}")
    (tmp_path / "secret.usda").write_text("#usda 1.0\n")
    monkeypatch.chdir(home)
    return home


def read(folder, body, **options):
    (folder / "a.yaml").write_text(f"tickgraph: 1\n{body}\n")
    return load("a.yaml", **options)


def problems(folder, body, **options):
    with pytest.raises(UserError) as caught:
        read(folder, body, **options)
    return [str(problem) for problem in caught.value.problems]


def test_a_scene_is_relative_to_its_graph_file_and_comes_out_absolute(folder):
    assert read(folder, "scene: {usd: scenes/yard.usda}").scene.usd == folder / "scenes" / "yard.usda"
    assert read(folder, "scene: {mjcf: ./scenes/../robot.xml}").scene.mjcf == folder / "robot.xml"


def test_the_folder_of_the_file_counts_not_the_current_one(folder, tmp_path, monkeypatch):
    read(folder, "scene: {usd: scenes/yard.usda}")
    monkeypatch.chdir(tmp_path)
    assert load("home/a.yaml").folder == folder


def test_an_absolute_path_below_the_folder_is_fine(folder):
    assert read(folder, f"scene: {{usd: {folder}/scenes/yard.usda}}").scene.usd == folder / "scenes" / "yard.usda"


@pytest.mark.parametrize("name", ["../secret.usda", "scenes/../../secret.usda", "link.usda", "up/secret.usda"])
def test_nothing_outside_the_folder_is_read_by_dots_or_links(folder, name):
    (folder / "link.usda").symlink_to("../secret.usda")
    (folder / "up").symlink_to("..")
    assert problems(folder, f"scene: {{usd: {name}}}") == [
        f'a.yaml:2:14: scene.usd: "{name}" is outside the graph file\'s folder; move it there, or allow its folder '
        f"with --allow {folder.parent}"
    ]


def test_a_file_outside_is_refused_in_the_same_words_whether_it_exists_or_not(folder):
    [one] = problems(folder, "scene: {usd: ../secret.usda}")
    [other] = problems(folder, "scene: {usd: ../nothing.usda}")
    assert other == one.replace("secret", "nothing")


def test_allow_widens_what_may_be_read(folder, tmp_path):
    assert read(folder, "scene: {usd: ../secret.usda}", allow=[tmp_path]).scene.usd == tmp_path / "secret.usda"
    assert read(folder, "scene: {usd: ../secret.usda}", allow=[".."]).scene.usd == tmp_path / "secret.usda"


@pytest.mark.parametrize(
    ("body", "line"),
    [
        (
            "scene: {usd: scenes/yrad.usda}",
            'a.yaml:2:14: scene.usd: there is no file "scenes/yrad.usda" (relative to the graph file); '
            'did you mean "yard.usda"?',
        ),
        (
            "scene: {mjcf: zzz.xml}",
            'a.yaml:2:15: scene.mjcf: there is no file "zzz.xml" (relative to the graph file)',
        ),
        ("scene: {usd: scenes}", 'a.yaml:2:14: scene.usd: "scenes" does not end in .usd or .usda or .usdc or .usdz'),
        ("scene: {usd: folder.usd}", 'a.yaml:2:14: scene.usd: "folder.usd" is a folder, not a file'),
        (
            "scene: {usd: omniverse://localhost/yard.usd}",
            'a.yaml:2:14: scene.usd: "omniverse://localhost/yard.usd" is a URL; only files below the graph file\'s '
            "folder are read",
        ),
        (
            "scene: {usd: robot.xml}",
            'a.yaml:2:14: scene.usd: "robot.xml" does not end in .usd or .usda or .usdc or .usdz',
        ),
        ("scene: {usd: loop.usda}", 'a.yaml:2:14: scene.usd: "loop.usda" is not a usable file name'),
        (
            "scene: {usd: scenes/yard.usda, mjcf: robot.xml}",
            "a.yaml:2:32: scene: give usd or mjcf, not both",
        ),
        (
            "scene: {prims: {/L: {type: OmniLidar, config: lidr.json}}}",
            'a.yaml:2:47: prim /L: config: there is no file "lidr.json" (relative to the graph file); '
            'did you mean "lidar.json"?',
        ),
        (
            "scene: {prims: {/R: {reference: ../secret.usda}}}",
            'a.yaml:2:33: prim /R: reference: "../secret.usda" is outside the graph file\'s folder; move it there, or '
            "allow its folder with --allow {parent}",
        ),
        (
            "record: {mcap: /tmp/x.mcap}",
            'a.yaml:2:16: record.mcap: "/tmp/x.mcap" could leave the output folder; give a plain name such as run.mcap',
        ),
        (
            "record: {mcap: a/../../x.mcap}",
            'a.yaml:2:16: record.mcap: "a/../../x.mcap" could leave the output folder; give a plain name such as '
            "run.mcap",
        ),
        ("record: {mcap: ''}", 'a.yaml:2:16: record.mcap: "" is not a file name'),
        ("record: {mcap: logs/}", 'a.yaml:2:16: record.mcap: "logs/" is not a file name'),
    ],
)
def test_a_file_name_that_does_not_work_is_one_line(folder, body, line):
    (folder / "folder.usd").mkdir()
    (folder / "loop.usda").symlink_to("loop.usda")
    assert problems(folder, body) == [line.replace("{parent}", str(folder.parent))]


def test_a_recording_may_lie_in_a_folder_below_the_output(folder):
    assert read(folder, "record: {mcap: logs/run1.mcap}").record.mcap == "logs/run1.mcap"
    assert read(folder, "duration: 1").record.mcap == "run.mcap"


def test_config_and_reference_files_arrive_absolute_and_config_names_as_they_are(folder):
    prims = read(
        folder,
        "scene: {prims: {/A: {config: lidar.json}, /B: {config: Example_Rotary}, /C: {reference: scenes/yard.usda}}}",
    ).scene.prims
    assert prims["/A"]["config"] == str(folder / "lidar.json")
    assert prims["/B"]["config"] == "Example_Rotary"
    assert prims["/C"]["reference"] == str(folder / "scenes" / "yard.usda")
