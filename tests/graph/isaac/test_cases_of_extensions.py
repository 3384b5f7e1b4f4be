"""The tool that runs the test cases of an extension, on an invented one."""

import pytest

from tests.support.isaac_cases.__main__ import main

CASES = """
import omni.kit.test
import omni.usd
from acme.help import answer
from acme.tool.tests.common import DEVICES, PAIR

class TestTool(omni.kit.test.AsyncTestCase):
    async def test_agrees(self):
        await omni.kit.app.get_app().next_update_async()
        self.assertTrue(omni.usd.get_context().get_stage())
        self.assertEqual(answer(), 42)
    def test_deviates(self):
        self.assertEqual(1, 2)
    def test_devices(self):
        self.assertEqual((DEVICES, PAIR), (["cpu"], ("cpu",)))
    def test_needs_more(self):
        from isaacsim.core.nodes import nothing_like_this
    def test_skips_itself(self):
        self.skipTest("not today")
    def test_takes_long(self):
        while True:
            pass
    def test_twice_wrong(self):
        for one in (1, 2):
            with self.subTest(one):
                self.assertEqual(one, 0)
"""


@pytest.fixture
def extension(tmp_path):
    tests = tmp_path / "acme.tool" / "acme" / "tool" / "tests"
    tests.mkdir(parents=True)
    (tests / "__init__.py").write_text("raise RuntimeError('loads every test')\n")
    (tests / "common.py").write_text('DEVICES = ["cpu", "cuda"]\nPAIR = ("cpu", "cuda")\n')
    (tests / "test_tool.py").write_text(CASES)
    (tests / "test_of_more.py").write_text(
        "import unittest\nimport acme.compiled\nclass TestMore(unittest.TestCase):\n    def test_a(self): pass\n"
    )
    (tmp_path / "acme.tool" / "acme" / "help.py").write_text("def answer():\n    return 42\n")
    return tmp_path / "acme.tool"


def test_each_case_agrees_deviates_is_out_of_reach_or_skips_itself(extension, capsys):
    assert main([str(extension), "--limit", "1", "--no-cuda", "--helpers", "acme"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[1:4]] == [
        ["acme.tool.tests.test_of_more", "1", "0", "0", "1", "0"],
        ["acme.tool.tests.test_tool", "7", "2", "3", "1", "1"],
        ["all", "8", "2", "3", "2", "1"],
    ]
    missing = [line for line in lines if line.startswith("out of reach:")]
    assert ["acme.compiled" in line or "nothing_like_this" in line for line in missing] == [True, True]
    assert [line for line in lines if line.startswith("deviates:")] == [
        "deviates: acme.tool.tests.test_tool.TestTool.test_deviates: AssertionError: 1 != 2",
        "deviates: acme.tool.tests.test_tool.TestTool.test_takes_long: TimeUpError: longer than 1.0 s",
        "deviates: acme.tool.tests.test_tool.TestTool.test_twice_wrong: AssertionError: 1 != 0",
    ]


def test_a_package_that_only_holds_tests_is_not_missing(tmp_path, capsys):
    tests = tmp_path / "acme.tests_only" / "acme" / "only" / "tests"
    tests.mkdir(parents=True)
    (tests / "test_gpu.py").write_text(
        "import unittest\nfrom isaacsim.core.simulation_manager import SimulationManager\n"
        "class TestGpu(unittest.TestCase):\n    def test_agrees(self): pass\n"
        "    def test_gpu(self): SimulationManager.set_physics_sim_device('cuda')\n"
    )
    assert main([str(tmp_path / "acme.tests_only")]) == 0
    assert capsys.readouterr().out.splitlines()[1].split() == ["acme.only.tests.test_gpu", "2", "1", "0", "1", "0"]


def test_one_case_is_chosen_by_its_name(extension, capsys):
    assert main([str(extension), "--only", "test_skips", "--helpers", "acme"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == ["all", "1", "0", "0", "0", "1"]


def test_a_folder_without_tests_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main([str(tmp_path)])
    assert "no folder has a module of tests" in capsys.readouterr().err
