"""Mistakes in a user's node that the types catch: a wrong name fails mypy before it fails a run."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

NODE = '''"""A node of somebody's own."""

from graph import Attribute, Database, node_type


@node_type("acme.Stamp", inputs={{"execIn": Attribute("execution", "go")}})
def stamp(db: Database) -> bool:
    """Say the time."""
    {line}
    return True
'''

RIGHT = (
    'if not db.inputs.gain: db.lack("give it a gain")',
    'db.warn("acme-late", str(db.app.simulation.time))',
    'db.outputs.value = db.context.delta_seconds + float(db.variables["gain"])',
)
WRONG = {
    'db.lak("no gain")': '"Database" has no attribute "lak"',
    "db.app.simulaton": '"App" has no attribute "simulaton"',
    "db.context.tme": '"Context" has no attribute "tme"',
    "db.warn(code=3)": 'Missing positional argument "message"',
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What mypy says of each line, by line; all in one run over one cache."""
    api = pytest.importorskip("mypy.api", reason="mypy is not installed")
    folder = tmp_path_factory.mktemp("computes")
    files = {line: folder / f"compute_{number}.py" for number, line in enumerate((*RIGHT, *WRONG))}
    for line, file in files.items():
        file.write_text(NODE.format(line=line), encoding="utf8")
    options = [f"--config-file={ROOT / 'pyproject.toml'}", f"--cache-dir={ROOT / '.mypy_cache'}"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MYPYPATH", str(ROOT))
        report, errors, _ = api.run([*options, f"--python-executable={sys.executable}", *map(str, files.values())])
    assert not errors
    return {
        line: [one for one in report.splitlines() if Path(one.partition(":")[0]).name == file.name]
        for line, file in files.items()
    }


@pytest.mark.parametrize("line", RIGHT)
def test_a_right_compute_passes(found, line):
    assert found[line] == []


@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_name_in_a_compute_is_an_error(found, line):
    assert any(WRONG[line] in one for one in found[line]), found[line]
