"""`graph doctor`: what it finds, what it advises, how it ends."""

import argparse
import itertools
import json
import re
import tomllib

import pytest

from graph.cli import doctor
from tests.support.places import ROOT


def run_doctor(*options):
    parser = argparse.ArgumentParser()
    doctor.add_arguments(parser)
    return doctor.run(parser.parse_args(options))


@pytest.fixture
def quick_imports(monkeypatch):
    """Only one dependency is tried: an import of everything takes seconds."""
    monkeypatch.setattr(doctor, "IMPORTS", {"networkx": ("networkx",)})


def test_a_ready_machine_ends_with_0_and_says_so(quick_imports, capsys):
    assert run_doctor() == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == "ready"
    assert [line.split()[0] for line in lines[:-1]].count("fail") == 0
    assert any(line.startswith("ok    networkx") and "imports in" in line for line in lines)


def test_json_lists_every_finding_with_its_state(quick_imports, capsys):
    assert run_doctor("--json") == 0
    report = json.loads(capsys.readouterr().out)
    assert report["ready"] is True
    names = [finding["name"] for finding in report["findings"]]
    machine = ["cores", "memory", "disk"]
    assert names == ["python", "C library", "system libraries", "networkx", "tickgraph", "compiled loops", *machine]
    assert {finding["state"] for finding in report["findings"]} <= {"ok", "warn"}


def test_import_times_are_numbers_in_json_and_the_heavy_ones_are_reported_to_come_on_first_use(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "IMPORTS", {"pxr.Usd": ("usd-core",), "networkx": ("networkx",)})
    assert run_doctor("--json") == 0
    found = {finding["name"]: finding for finding in json.loads(capsys.readouterr().out)["findings"]}
    assert all(0 < found[name]["import_s"] < 60 for name in ("usd-core", "networkx", "tickgraph"))
    assert found["memory"]["import_s"] is None
    assert found["usd-core"]["detail"].endswith("on first use")
    assert not found["networkx"]["detail"].endswith("on first use")


def test_it_says_whether_our_packages_come_without_the_heavy_libraries(quick_imports, monkeypatch, capsys):
    assert run_doctor() == 0
    assert "without the heavy libraries" in capsys.readouterr().out
    monkeypatch.setattr(doctor, "LAZY_PROBE", "print(0.5, 'mujoco')")
    assert run_doctor() == 0
    assert "warn  tickgraph         imports in 0.50 s and loads mujoco with it" in capsys.readouterr().out


def test_every_dependency_is_looked_at():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))["project"]["dependencies"]
    names = {re.split(r"[^A-Za-z0-9._-]", each)[0] for each in declared}
    assert names == set(itertools.chain.from_iterable(doctor.IMPORTS.values())) - {"mujoco"}


def test_a_missing_package_ends_with_1_and_names_the_command(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "IMPORTS", {"no_such_module": ("no-such-distribution",)})
    assert run_doctor() == 1
    out = capsys.readouterr().out
    assert "fail  no-such-distribution  not installed" in out
    assert out.endswith("not ready\n  Run: pip install no-such-distribution\n")


def test_a_package_that_does_not_import_is_a_finding_with_its_last_line(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "IMPORTS", {"networkx.no_such_part": ("networkx",)})
    assert run_doctor() == 1
    assert "does not import: ModuleNotFoundError: No module named 'networkx.no_such_part'" in capsys.readouterr().out


def test_missing_system_libraries_name_the_one_line_that_installs_them(monkeypatch, quick_imports, capsys):
    from graph.sim import libraries

    monkeypatch.setattr(libraries, "missing_system_libraries", lambda: ("libEGL.so.1",))
    assert run_doctor() == 1
    out = capsys.readouterr().out
    assert "missing: libEGL.so.1" in out
    assert "Run as root: apt-get install -y --no-install-recommends libgl1 libegl1" in out


def test_little_memory_and_disk_warn_but_do_not_stop(monkeypatch, quick_imports, capsys):
    monkeypatch.setattr(doctor, "LITTLE_MEMORY", 2**60)
    monkeypatch.setattr(doctor, "LITTLE_DISK", 2**60)
    assert run_doctor() == 0
    out = capsys.readouterr().out
    assert out.count("warn") == 2
    assert "Recordings want space" in out


def test_open3d_without_its_libraries_is_a_users_error_with_the_command(monkeypatch):
    import ctypes
    import sys

    from graph.base.errors import UserError
    from graph.sim import libraries

    monkeypatch.delitem(sys.modules, "open3d", raising=False)
    load = ctypes.CDLL

    def without_gl(name, *more, **options):
        if name == "libGL.so.1":
            raise OSError(f"{name}: cannot open shared object file")
        return load(name, *more, **options)

    monkeypatch.setattr(ctypes, "CDLL", without_gl)
    with pytest.raises(UserError, match=r"needs libGL\.so\.1, which is missing on this machine\. Run: apt-get install"):
        libraries.import_open3d()


def test_loops_are_compiled_ahead_once(monkeypatch, capfd, tmp_path):
    """Two forms instead of all; a second warm-up finds them."""
    from sensors.compiled import signatures, warming

    monkeypatch.setenv("TICKGRAPH_CACHE", str(tmp_path))
    two = signatures.listed()[:2]
    monkeypatch.setattr(warming, "listed", lambda: two)
    # A forked process would have the loops that earlier tests compiled.
    monkeypatch.setattr(warming, "get_all_start_methods", lambda: ["spawn"])
    assert run_doctor("--warm") == 0
    said = capfd.readouterr()  # that of the processes that compile, too
    assert said.out.startswith("compiled 2 loops in ")
    assert said.err == "compiling 2 loops of the sensors, once on this machine\n"
    assert len(list((tmp_path / "kernels").glob("*.bin"))) == 2
    assert run_doctor("--warm") == 0
    assert capfd.readouterr().out == "the sensors' loops are compiled already\n"


def test_where_compiled_loops_cannot_be_kept_it_says_why_and_what_to_do(quick_imports, monkeypatch, capsys, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("TICKGRAPH_CACHE", str(tmp_path / "file"))
    assert run_doctor() == 0
    said = capsys.readouterr().out
    assert f"warn  compiled loops    cannot be kept: {tmp_path / 'file' / 'kernels'}: Not a directory" in said
    assert "Set TICKGRAPH_CACHE to a folder of your own" in said
    assert run_doctor("--warm") == 1
