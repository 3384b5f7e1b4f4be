"""Files are opened for reading by `graph.base.inputs` and written by `graph.base.outputs`, nowhere else."""

import ast

import pytest

from tests.support.places import PACKAGES, ROOT
from tests.support.without_wing import is_missing

OPENERS = ("graph/base/inputs.py", "graph/base/outputs.py")
OWN = ("sensors/compiled/kept.py", "sensors/compiled/__main__.py", "sensors/compiled/signatures.py")
"""Modules of the compiled loops, which the package and the user's own cache folder hold."""
METHODS = frozenset(
    [
        "Export",
        "NamedTemporaryFile",
        "Save",
        "TemporaryDirectory",
        "TemporaryFile",
        "ZipFile",
        "copy2",
        "copyfile",
        "copytree",
        "fromfile",
        "genfromtxt",
        "hardlink_to",
        "link_to",
        "loadtxt",
        "makedirs",
        "memmap",
        "mkdir",
        "mkdtemp",
        "mkstemp",
        "move",
        "read_bytes",
        "read_text",
        "rename",
        "rmdir",
        "rmtree",
        "savefig",
        "savetxt",
        "savez",
        "savez_compressed",
        "symlink_to",
        "tofile",
        "touch",
        "unlink",
        "write_bytes",
        "write_text",
    ]
)
"""Names of functions that open, make, move or remove files, whatever they belong to."""
OF_MODULES = frozenset(
    [
        "codecs.open",
        "io.FileIO",
        "io.open",
        "np.load",
        "np.save",
        "np.savez",
        "numpy.load",
        "numpy.save",
        "os.fdopen",
        "os.open",
        "os.remove",
        "os.replace",
        "shutil.copy",
        "sqlite3.connect",
    ]
)
"""Functions whose names alone say too little."""
ALLOWED = {
    ("graph/cli/main.py", "os.open"): "the null device in the place of a closed stream",
    ("graph/cli/main.py", "open"): "the null device in the place of a closed stream",
    ("graph/cli/output_folder.py", "os.open"): "the lock of a folder",
    ("graph/base/silence.py", "os.open"): "the null device",
    ("graph/testing/pytest_plugin.py", "os.open"): "a module that may import nothing of ours; refuses all but files",
    ("graph/testing/pytest_plugin.py", "open"): "the same",
    ("wings/trade/workers.py", "os.open"): "the null device",
    ("wings/campaign/server.py", "os.open"): "the null device",
    ("wings/campaign/cluster.py", "tempfile.TemporaryDirectory"): "a worker's own folders",
    ("wings/trade/conduct.py", "tempfile.TemporaryDirectory"): "a study's own folder",
    ("graph/base/plotting.py", "figure.savefig"): "into a stream in memory",
    ("wings/trade/jobs.py", "self.file.open"): "a study's own folder",
    ("wings/trade/jobs.py", "file.open"): "a study's own folder",
    ("graph/cli/convert.py", "tempfile.TemporaryDirectory"): "where USD writes a layer, which is then copied",
    ("graph/cli/convert.py", "layer.Export"): "into that folder",
    ("graph/base/extras.py", "metadata.distribution('tickgraph').read_text"): "the installation's own note",
    ("graph/cli/examples.py", "file.open"): "shipped examples",
    ("graph/cli/examples.py", "file.read_text"): "shipped examples",
    ("graph/cli/examples.py", "file.read_bytes"): "shipped examples",
    ("graph/cli/new.py", "file.read_bytes"): "shipped examples",
    ("graph/cli/new.py", "resources.files(__package__).joinpath('templates', name).read_text"): "a shipped template",
    ("graph/manual/__init__.py", "resources.files(__package__).joinpath(f'{topic}.md').read_text"): "shipped pages",
    ("graph/isaac/names.py", "resources.files(__package__).joinpath('names.txt').read_text"): "a shipped table",
    ("graph/isaac/modules/usd.py", "app().stage.Flatten().Export"): "the file that a script names for its stage",
    ("graph/isaac/saving.py", "(stage.Flatten() if stand_ins else own).Export"): "the file that a script opened",
    ("graph/isaac/modules/replicator_files.py", "np.save"): "into a stream in memory",
    ("graph/ogn/packages.py", "file.read_bytes"): "a declaration inside a package that is no folder",
    ("wings/exports/point_files.py", "np.savez_compressed"): "into a stream of the output opener",
    ("wings/exports/files.py", "np.savez_compressed"): "into a stream of the output opener",
    ("sensors/writers/basic.py", "np.save"): "into a stream in memory",
    ("graph/sim/scene/layer_text.py", "zipfile.ZipFile"): "a package whose start was read by the input opener",
    ("sensors/camera/image_files.py", "zipfile.ZipFile"): "a package that was found to be a regular file",
    ("wings/view/writing.py", "(files(__package__) / 'page' / name).read_text"): "shipped data",
    ("graph/recording/bag_source.py", "sqlite3.connect"): "a file that the input opener has seen",
}
"""(module, call) -> why it may."""
NO_FILES = frozenset(["Pillow.open", "gripper.open", "memory.bus.open", "package.open", "scene.open", "zenoh.open"])
"""Calls named `open` for a stream, a member of a package, a network, rays, fingers, an inbox."""


def calls(source):
    """The calls in a text that may open files, as they are written, with their lines."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        last = name.rpartition(".")[2]
        method = isinstance(node.func, ast.Attribute) or last[0].isupper()
        if name == "open" or name in OF_MODULES or (method and last in (*METHODS, "open") and name not in NO_FILES):
            yield name, node.lineno


def modules():
    return [
        (path.relative_to(ROOT).as_posix(), path)
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    ]


def test_no_module_opens_files_but_the_two_openers():
    found = {
        (module, name): line
        for module, path in modules()
        if module not in (*OPENERS, *OWN)
        for name, line in calls(path.read_text())
    }
    assert {f"{one[0]}:{line}: {one[1]}" for one, line in found.items() if one not in ALLOWED} == set()


def test_every_exception_is_in_use():
    found = {(module, name) for module, path in modules() for name, _ in calls(path.read_text())}
    assert {one for one in ALLOWED if not is_missing(one[0])} - found == set()


@pytest.mark.parametrize(
    "text",
    [
        "open(name)",
        "path.open('wb')",
        "path.open()",
        "Path(name).write_text('')",
        "os.open(name, 0)",
        "np.load(name)",
        "folder.mkdir()",
        "sqlite3.connect(name)",
        "figure.savefig(name)",
    ],
)
def test_a_call_that_opens_a_file_is_seen(text):
    assert len(list(calls(text))) == 1


@pytest.mark.parametrize("text", ["gripper.open()", "Pillow.open(stream)", "text.replace('a', 'b')"])
def test_other_calls_are_not(text):
    assert list(calls(text)) == []
