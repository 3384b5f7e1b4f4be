"""Who may know whom: the arrows between the packages, and what an import may load."""

import ast
import functools
import itertools
import re
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec

import networkx
import pytest

from tests.support.places import PACKAGES, ROOT
from tests.support.without_wing import MISSING_WINGS, is_missing

HEAVY = ("mujoco", "numba", "open3d", "pxr", "matplotlib")

DOORS = ("graph", "graph.sim")
"""What users import from; each is a table of names that stand elsewhere."""
NOT_MODULES = ("graph.values",)
"""Texts that name a limit, not a module."""


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))}


@functools.cache
def imports_of(name, path, top_level_only=False, for_types=False):
    """(module, line) of each import of a module; relative ones resolved. for_types: those under TYPE_CHECKING too."""
    found = []

    def visit(node):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test) and not for_types:
            for child in node.orelse:
                visit(child)
            return
        if top_level_only and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            return
        if isinstance(node, ast.Import):
            found.extend((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = name if path.name == "__init__.py" else name.rpartition(".")[0]
            base = node.module or ""
            if node.level:
                anchor = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*anchor, *filter(None, [base])])
            for alias in node.names:
                whole = f"{base}.{alias.name}"
                found.append((whole if whole in MODULES else base, node.lineno))
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(tree_of(path))
    return found


@functools.cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf8"))


def room(name):
    """The room that a module lies in: a folder of `graph`, or another package; "" for the doors and other modules."""
    first, _, rest = name.partition(".")
    if name in (*DOORS, "graph.__main__") or first not in PACKAGES:
        return ""
    return rest.partition(".")[0] if first == "graph" else first


def rooms_of(for_types):
    """The rooms and what they import, at any depth, and what they name in texts, by which it could be imported."""
    found = networkx.DiGraph()
    for name, path in MODULES.items():
        texts = ((one.value, one.lineno) for one in ast.walk(tree_of(path)) if isinstance(one, ast.Constant))
        named = ((one, line) for one, line in texts if one in MODULES and "." in one and one not in NOT_MODULES)
        for target, line in (*imports_of(name, path, for_types=for_types), *named):
            if room(name) and room(target) and room(name) != room(target):
                found.add_edge(room(name), room(target), where=f"{path.relative_to(ROOT)}:{line}")
    return found


def drawn(arrow):
    """The arrows of a kind in the drawing on the page of `graph`."""
    page = (ROOT / "graph/README.md").read_text(encoding="utf8")
    lines = page.partition("flowchart BT\n")[2].partition("```")[0].splitlines()
    found = [line.split(f" {arrow} ") for line in lines if f" {arrow} " in line]
    return {(one.strip(), target.strip()) for one, targets in found for target in targets.split("&")}


def test_the_drawing_shows_which_room_imports_which():
    """Each room imports only those below it, and the arrows drawn are the fewest that say which."""
    rooms, with_types = rooms_of(for_types=False), rooms_of(for_types=True)
    circles = [sorted(part) for part in networkx.strongly_connected_components(with_types) if len(part) > 1]
    assert circles == [], [with_types.edges[edge] for part in circles for edge in with_types.subgraph(part).edges]
    needed = set(networkx.transitive_reduction(rooms).edges)
    of_types = set(networkx.transitive_reduction(with_types).edges) - needed
    differing = (drawn("-->") ^ needed) | (drawn("-.->") ^ of_types)
    # what all wings import is not known where one is missing
    assert {arrow for arrow in differing if arrow[0] != "wings" or not MISSING_WINGS} == set()


def test_no_wing_imports_another():
    wrong = [
        f"{path.relative_to(ROOT)}:{line}: {target}"
        for name, path in MODULES.items()
        for target, line in imports_of(name, path, for_types=True)
        if room(name) == room(target) == "wings" and name.split(".")[1:2] != target.split(".")[1:2]
    ]
    assert wrong == []


def test_nothing_inside_imports_from_a_door():
    """`from graph import ...` and `from graph.sim import App` are for users: a room imports from rooms."""
    wrong = [
        f"{path.relative_to(ROOT)}:{line}"
        for name, path in MODULES.items()
        for target, line in imports_of(name, path, for_types=True)
        if target in DOORS
    ]
    assert wrong == []


def test_the_stub_of_the_door_names_where_its_names_stand():
    """Type checkers read `graph/sim/__init__.pyi`; what is imported is what the table says."""
    door = import_module("graph.sim")
    stub = ROOT / "graph/sim/__init__.pyi"
    homes = {}
    for line in tree_of(stub).body[1:]:
        module = f"graph.sim.{line.module}" if line.level else line.module
        homes |= {alias.asname: module for alias in line.names}
    assert sorted(homes) == sorted(door.__all__)
    for name, module in homes.items():
        if name == "Worlds" and "device" in MISSING_WINGS:
            continue
        whole = f"{module}.{name}"
        home = import_module(whole) if whole in MODULES else getattr(import_module(module), name)
        assert getattr(door, name) is home, name


def test_sensors_name_an_app_for_its_type_alone():
    """They see a `WorldView`."""
    wrong = [
        f"{path.relative_to(ROOT)}:{line}"
        for name, path in MODULES.items()
        if name.startswith("sensors.")
        for target, line in imports_of(name, path)
        if target == "graph.sim.app" and names_app(path, line)
    ]
    assert wrong == []


def names_app(path, line):
    """Whether the import in a line brings the class App."""
    tree = ast.parse(path.read_text(encoding="utf8"))
    imports = (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.lineno == line)
    return any(alias.name == "App" for node in imports for alias in node.names)


def test_no_module_imports_itself_in_a_circle():
    modules = networkx.DiGraph()
    for name, path in MODULES.items():
        for target, _ in imports_of(name, path, top_level_only=True):
            if target in MODULES and target != name:
                modules.add_edge(name, target)
    circles = [sorted(part) for part in networkx.strongly_connected_components(modules) if len(part) > 1]
    assert circles == []


def test_a_circle_of_files_stays_in_its_folder():
    """Imports at any depth, those for types alone too: an engine and its parts know each other, rooms do not."""
    modules = networkx.DiGraph()
    for name, path in MODULES.items():
        for target, _ in imports_of(name, path, for_types=True):
            if target in MODULES and target != name:
                modules.add_edge(name, target)
    circles = [sorted(part) for part in networkx.strongly_connected_components(modules) if len(part) > 1]
    assert [part for part in circles if len({MODULES[name].parent for name in part}) > 1] == []


def test_the_rooms_of_the_world_stand_above_each_other():
    """Two know each other: faces that a graph file writes are checked as triangles."""
    rooms = networkx.DiGraph()
    for name, path in MODULES.items():
        for target, _ in imports_of(name, path, for_types=True):
            if world_room(name) and world_room(target) and world_room(name) != world_room(target):
                rooms.add_edge(world_room(name), world_room(target))
    circles = [sorted(part) for part in networkx.strongly_connected_components(rooms) if len(part) > 1]
    assert circles == [["geometry", "scene"]]


def world_room(name):
    """The folder of `graph.sim` in which a module lies, else its own name there; "" outside and for the package."""
    return name.split(".")[2] if name.startswith("graph.sim.") else ""


def loaded_after(code):
    """Which of the heavy libraries a fresh interpreter has loaded after `code`."""
    report = f"\nimport sys; print(*(name for name in {HEAVY!r} if name in sys.modules), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code + report], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr.split()


def test_import_graph_loads_no_heavy_library_and_no_numpy():
    code = "import graph, sys; assert 'numpy' not in sys.modules, 'numpy'"
    assert loaded_after(code) == []


@pytest.mark.parametrize("package", ["graph.sim", "sensors", "nodes", "wings", "graph.cli", "graph.testing"])
def test_importing_a_package_loads_no_heavy_library(package):
    assert loaded_after(f"import {package}") == []


@pytest.mark.parametrize(
    "names",
    [
        "graph.sim: App, PhysicsScene, NewtonMjcScene, RenderingManager, SimulationManager, SimulationEvent",
        "sensors: SUPPORTED_LIDAR_CONFIGS, parse_generic_model_output_data",
    ],
)
def test_naming_what_a_script_needs_loads_no_heavy_library(names):
    package, _, wanted = names.partition(": ")
    assert loaded_after(f"from {package} import {wanted}") == []


def test_an_app_loads_only_what_its_world_needs():
    """An empty world needs USD; physics comes with the first body, the ray caster with the first sensor."""
    code = "from graph.sim import App\nwith App() as app:\n    app.play(); app.update(3)\n"
    assert loaded_after(code) == ["pxr"]
    body = "    app.stop(); app.add_prims({'/Ball': {'type': 'Sphere', 'rigid_body': True}}); app.play()\n"
    assert loaded_after(code + body) == ["mujoco", "pxr"]


def test_help_of_the_command_loads_no_heavy_library():
    code = (
        "import sys; from graph.cli.main import main\n"
        "sys.argv = ['graph', '--help']\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code"
    )
    assert loaded_after(code) == []


def test_listing_node_types_loads_no_heavy_library():
    code = (
        "import sys; from graph.cli.main import main\n"
        "sys.argv = ['graph', 'nodes', 'Countdown']\n"
        "try: assert not main()\n"
        "except SystemExit as end: assert not end.code"
    )
    assert loaded_after(code) == []


def test_checking_a_file_loads_usd_and_the_modules_of_its_own_nodes():
    """Those of the quickstart: events, the simulation time, render products, the clock and the lidar helper."""
    code = (
        "import sys; from graph.cli.main import main\n"
        "assert not main(['check', 'graphs/quickstart.yaml'])\n"
        "from nodes import TYPES\n"
        "loaded = [name for name in TYPES if f'nodes.{name}' in sys.modules]\n"
        "own = ['action.events', 'isaac.clocks', 'isaac.render_products', 'ros2.clock', 'ros2.lidar_helper']\n"
        "assert loaded == own, loaded"
    )
    assert loaded_after(code) == ["pxr"]


def test_checking_the_yard_loads_nothing_that_measures():
    """Its lidars, radar and camera are read and scheduled; what casts, traces and shades stays away."""
    code = (
        "import sys; from graph.cli.main import main\n"
        "assert not main(['check', 'graphs/yard.yaml'])\n"
        "own = ('lidar.scans', 'radar.scans', 'radar.tracing', 'camera.imager', 'raycast.world', 'raycast.triangles')\n"
        "assert 'sensors.camera.runtime' in sys.modules\n"
        "loaded = [name for name in own if f'sensors.{name}' in sys.modules]\n"
        "assert loaded == [], loaded"
    )
    assert loaded_after(code) == ["pxr"]


def without_warp():
    """The kernels that Warp compiles, where the extra gpu is not installed."""
    return set() if find_spec("warp") else {name for name in MODULES if name.endswith("kernels")}


def test_every_module_imports_without_the_heavy_libraries():
    """Only files that own a library may need it at import; they are reached when their subject is."""
    owners = {name for name, path in MODULES.items() if "TID253" in path.read_text(encoding="utf8")}
    plain = sorted(set(MODULES) - owners - {"graph.__main__"} - without_warp())
    blocker = (
        "import importlib, sys\n"
        f"for name in {HEAVY!r}: sys.modules[name] = None\n"
        "failed = []\n"
        f"for name in {plain!r}:\n"
        "    try: importlib.import_module(name)\n"
        "    except ImportError as error: failed.append(f'{name}: {error}')\n"
        "print(*failed, sep='\\n', end='')"
    )
    done = subprocess.run([sys.executable, "-c", blocker], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    # A module built on an owner needs the same library; everything else must not.
    missing = {line.partition(":")[0] for line in done.stdout.splitlines()}
    assert missing <= built_on(owners)


def test_every_module_imports_where_posix_alone_has_something():
    """As on Windows: no SIGHUP, no fcntl, no CPU affinity, no terminal settings."""
    elsewhere = (
        "import importlib, os, signal, sys\n"
        "for name in ('fcntl', 'resource', 'termios', 'tty', 'pwd', 'grp'): sys.modules[name] = None\n"
        "for name in ('SIGHUP', 'SIGKILL', 'SIGQUIT', 'SIGUSR1', 'SIGALRM', 'SIGPIPE'): delattr(signal, name)\n"
        "for name in ('fork', 'getuid', 'geteuid', 'sched_getaffinity', 'statvfs'): delattr(os, name)\n"
        f"for name in {sorted(set(MODULES) - {'graph.__main__'} - without_warp())!r}: importlib.import_module(name)\n"
    )
    done = subprocess.run([sys.executable, "-c", elsewhere], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def built_on(owners):
    """Modules that import an owner at their top level, directly or through others."""
    users = networkx.DiGraph()
    for name, path in MODULES.items():
        users.add_edges_from((target, name) for target, _ in imports_of(name, path, top_level_only=True))
    return set(itertools.chain.from_iterable(networkx.descendants(users, owner) for owner in owners if owner in users))


OWNERS = {
    "mujoco": ["graph.sim.physics.mujoco.library"],
    "numba": ["sensors.compiled.kept"],
    "open3d": ["graph.sim.libraries"],
    "pxr": ["graph.sim.usd"],
    "matplotlib": ["graph.base.plotting", "wings.trade.diagrams"],
}
"""The files that import each heavy library, on first use: one, or one for colors and PNGs and one for diagrams."""


@pytest.mark.parametrize("library", HEAVY)
def test_each_heavy_library_is_imported_by_its_owners_alone(library):
    """At any depth: inside functions and by `import_module` too."""
    importers = [
        name
        for name, path in MODULES.items()
        if any(target.partition(".")[0] == library for target, _ in (*imports_of(name, path), *named_imports(path)))
    ]
    assert importers == [name for name in OWNERS[library] if not is_missing(name)]


KNOW_MUJOCO = ("graph.sim.physics.mujoco", "wings.mjcf", "wings.opengl", "wings.device")
"""What owns MuJoCo's models and data: the engine, its file format, its renderer, and its steps on a device."""


def knows_mujoco(name):
    return any(name == owner or name.startswith(f"{owner}.") for owner in KNOW_MUJOCO)


def test_only_the_default_factory_imports_the_mujoco_engine():
    """The world and what runs over it speak to `graph.sim.physics.protocol`."""
    importers = {
        (name, target)
        for name, path in MODULES.items()
        for target, _ in imports_of(name, path)
        if target.startswith(KNOW_MUJOCO[0]) and not knows_mujoco(name)
    }
    engine = {"graph.sim.physics.mujoco.compile", "graph.sim.physics.mujoco.engine"}
    assert importers == {("graph.sim.physics", target) for target in engine}


def test_nothing_else_reads_mujocos_model_or_data():
    """`x.physics.model`, `physics.data`, `mj_step`, `mjtJoint`, `qpos` and the like."""
    own = re.compile(r"mjt?_?[A-Z]\w+|mj_\w+|qpos|qvel|qfrc_\w+|xfrc_\w+|efc_\w+|mocap_\w+")

    def reads_mujoco(node):
        owner = getattr(node.value, "attr", getattr(node.value, "id", ""))
        return own.fullmatch(node.attr) or (owner == "physics" and node.attr in ("model", "data"))

    wrong = [
        f"{path.relative_to(ROOT)}:{node.lineno}: .{node.attr}"
        for name, path in MODULES.items()
        if not knows_mujoco(name)
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Attribute) and reads_mujoco(node)
    ]
    assert wrong == []


@functools.cache
def named_imports(path):
    """(module, line) of each call such as `import_module("open3d")`."""
    found = []
    for call in (node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call)):
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        first = call.args[0] if call.args else None
        if name in ("import_module", "__import__") and isinstance(first, ast.Constant) and isinstance(first.value, str):
            found.append((first.value, call.lineno))
    return found
