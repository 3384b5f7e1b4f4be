"""What ships: version, licence, pins, package data, and that `make` can find what it needs."""

import os
import re
import runpy
import subprocess
import sys
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

from tests.support.places import PACKAGES, ROOT

SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))
PROJECT = SETTINGS["project"]
PINS = dict(
    line.split("==")
    for line in (ROOT / ".ci" / "constraints.txt").read_text(encoding="utf8").splitlines()
    if "==" in line
)


def normalised(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def requirement_names():
    groups = [PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()]
    return {normalised(re.match(r"[A-Za-z0-9._-]+", line)[0]) for group in groups for line in group}


def test_every_dependency_is_pinned_for_a_fresh_install():
    pinned = {normalised(name) for name in PINS}
    # open3d stands in for open3d-cpu on other platforms than the one the pins were made on.
    assert requirement_names() - pinned <= {"open3d"}


def test_the_pins_lie_within_the_projects_ranges():
    from packaging.requirements import Requirement

    pins = {normalised(name): version for name, version in PINS.items()}
    groups = [PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()]
    outside = [
        line
        for line in (Requirement(text) for group in groups for text in group)
        if normalised(line.name) in pins and not line.specifier.contains(pins[normalised(line.name)])
    ]
    assert outside == []


def test_the_pins_fit_each_other():
    """What the pinned versions that are installed here ask for themselves; of the others only `pip` knows."""
    from packaging.requirements import Requirement

    pins = {normalised(name): version for name, version in PINS.items()}
    wrong = [
        f"{one.name} {one.version}: {line}"
        for one in metadata.distributions()
        if pins.get(normalised(one.name)) == one.version
        for line in map(Requirement, one.requires or ())
        if (line.marker is None or line.marker.evaluate({"extra": ""}))
        and normalised(line.name) in pins
        and not line.specifier.contains(pins[normalised(line.name)])
    ]
    assert wrong == []


def test_no_pin_brings_another_engine_than_ours():
    """The package mujoco writes into the same folder as mujoco-core, and asks for one exact version of it."""
    assert "mujoco-core" in PINS
    assert not {"mujoco", "mujoco-studio"} & set(PINS)


def test_the_licence_is_apache_2():
    text = (ROOT / "LICENSE").read_text(encoding="utf8")
    assert PROJECT["license"] == "Apache-2.0"
    assert "Apache License" in text
    assert "END OF TERMS AND CONDITIONS" in text


def test_the_change_log_knows_the_version():
    assert re.fullmatch(r"\d+\.\d+\.\d+", PROJECT["version"])
    assert f"\n## {PROJECT['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf8")


def test_the_doctor_looks_at_every_dependency():
    from graph.cli.doctor import IMPORTS

    known = {normalised(name) for names in IMPORTS.values() for name in names}
    wanted = {normalised(re.match(r"[A-Za-z0-9._-]+", line)[0]) for line in PROJECT["dependencies"]}
    assert wanted <= known


def test_the_doctor_and_make_name_the_same_system_libraries():
    from graph.sim.libraries import INSTALL_HINT, SYSTEM_LIBRARIES

    script = (ROOT / ".ci" / "system-libraries").read_text(encoding="utf8")
    assert INSTALL_HINT in script
    assert all(f'"{library}"' in script for library in SYSTEM_LIBRARIES)


def test_the_wheel_ships_every_file_that_the_packages_read(tmp_path):
    pytest.importorskip("hatchling", reason="comes with the dev extra")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    [wheel] = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        shipped = set(archive.namelist())
    elsewhere = SETTINGS["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    kept = {
        elsewhere.get(str(path.relative_to(ROOT)), str(path.relative_to(ROOT)))
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert kept <= shipped
    assert any(name.endswith("licenses/LICENSE") for name in shipped)
    examples = [path.relative_to(ROOT / "graphs") for path in (ROOT / "graphs").rglob("*") if path.is_file()]
    assert {f"tickgraph_examples/{path}" for path in examples if "__pycache__" not in path.parts} <= shipped
    assert not any(name.startswith("tests") for name in shipped)


def test_make_says_clearly_when_there_is_no_python(tmp_path):
    for name in ("sh", "env"):
        (tmp_path / name).symlink_to(f"/bin/{name}")
    done = subprocess.run(
        [ROOT / ".ci" / "find-python"], env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert "Python 3.11 or newer" in done.stderr


def test_make_looks_for_system_libraries_before_it_installs_and_says_how_much():
    # --always-make: as in a fresh clone, whatever this checkout has installed
    planned = subprocess.run(
        ["make", "--dry-run", "--always-make", "run"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert planned.index(".ci/system-libraries") < planned.index("about 1.2 GB") < planned.index("--editable .")


def test_make_takes_the_python_it_is_given():
    environment = {**os.environ, "PYTHON": sys.executable}
    done = subprocess.run([ROOT / ".ci" / "find-python"], env=environment, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == sys.executable


def our_files():
    """Every text file of the project: its own folders, and the files beside pyproject.toml."""
    folders = [".ci", ".github", *PACKAGES, "graphs", "tests"]
    found = [path for folder in folders for path in (ROOT / folder).rglob("*")] + list(ROOT.glob("*"))
    binary = {".bin", ".usdc", ".mcap", ".gz", ".png"}
    texts = (path for path in found if path.suffix not in binary and "__pycache__" not in path.parts)
    return sorted(path for path in texts if path.is_file() and path != Path(__file__))


def test_no_file_speaks_of_a_place_outside_the_repository():
    """Sentences about one machine's folders are of no use to a reader of this one."""
    outside = re.compile(r"/(?:home|root|tmp/[a-z]|Users)/\w|\.\./(?:shared|plan)|https?://(?:localhost|\d+\.\d+)")
    found = []
    for path in our_files():
        for number, line in enumerate(path.read_text(encoding="utf8").splitlines(), 1):
            if outside.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}")
    assert found == []


def test_no_file_is_left_unfinished():
    mark = re.compile(r"\b(?:TODO|FIXME|XXX)\b|not implemented yet")
    found = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in our_files()
        if path.suffix == ".py"
        for number, line in enumerate(path.read_text(encoding="utf8").splitlines(), 1)
        if mark.search(line)
    ]
    assert found == []


@pytest.mark.parametrize(
    ("line", "step"),
    [
        (
            "  Downloading open3d_cpu-0.20.0-cp311-cp311-manylinux_2_35_x86_64.whl (115.3 MB)",
            "downloading open3d-cpu: 115 MB",
        ),
        (
            "Downloading https://host/x/usd_core-26.11-cp311-none-manylinux2014_x86_64.whl (28.9 MB)",
            "downloading usd-core: 29 MB",
        ),
        ("Downloading rich-15.0.0-py3-none-any.whl (310 kB)", None),
        ("Downloading pillow-13.0.0-cp311-cp311-manylinux_2_28_x86_64.whl (7.0 MB)", None),
        ("Collecting numpy>=1.26", None),
        ("Installing collected packages: numpy, rich, usd-core", "installing 3 packages"),
    ],
)
def test_make_prints_a_line_for_each_large_step_of_pip(line, step):
    script = runpy.run_path(str(ROOT / ".ci" / "pip"))
    assert script["large_step"](line.strip()) == step
