"""The table of Isaac Sim's names."""

import subprocess
import sys
from importlib import import_module

import pytest

import graph.isaac
from graph.isaac.finder import ROS
from graph.isaac.names import table
from tests.support.places import ROOT


def test_every_name_of_every_module_is_there():
    with graph.isaac.importable():
        missing = [
            f"{module}.{name}"
            for module, names in table().items()
            for name in names.public()
            if module.partition(".")[0] not in ROS and not hasattr(import_module(module), name)
        ]
    assert missing == []


def test_importable_ends_with_its_block():
    with graph.isaac.importable():
        carb = import_module("carb")
    assert carb.__name__ == "carb"
    assert "carb" not in sys.modules
    with pytest.raises(ImportError):
        import_module("carb")


def test_an_installed_module_is_never_replaced(tmp_path):
    (tmp_path / "omni" / "usd").mkdir(parents=True)
    (tmp_path / "omni" / "usd" / "__init__.py").write_text("real = True\n")
    code = f"""import sys
sys.path.insert(0, {str(tmp_path)!r})
import graph.isaac
with graph.isaac.importable():
    import omni.timeline
    import omni.usd
    print(omni.usd.real, omni.timeline.get_timeline_interface() is not None)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "True True\n"


def test_modules_load_no_library_until_they_are_used():
    code = """import sys
import graph.isaac
with graph.isaac.importable():
    import isaacsim, omni, carb, usdrt, omni.usd, omni.kit.app, omni.graph.core, omni.replicator.core
print([name for name in ("numpy", "pxr", "mujoco", "open3d") if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
