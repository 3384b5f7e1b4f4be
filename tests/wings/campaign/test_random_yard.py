"""The example of a randomised world: a run alone makes the bytes of the campaign's run, drawn by the seed or not."""

from __future__ import annotations

import shutil

import pytest

from graph.cli.main import main
from tests.support.places import ROOT

UPDATES = "7"  # of 1/60 s: one scan of 0.1 s is whole


@pytest.mark.parametrize("drawn", [True, False], ids=["randomised", "as written"])
def test_a_run_alone_makes_the_bytes_of_the_campaign(tmp_path, drawn):
    text = (ROOT / "graphs/random_yard.yaml").read_text()
    before, _, rest = text.partition("randomize:\n")
    if not drawn:
        text = before + rest[rest.index("graphs:\n") :]
    shutil.copytree(ROOT / "graphs/scenes", tmp_path / "scenes")
    yard = tmp_path / "yard.yaml"
    yard.write_text(text)
    assert main(["sweep", str(yard), "--vary", "seed=0..1", "--updates", UPDATES, "--out", str(tmp_path / "c")]) == 0
    assert main(["run", str(yard), "--seed", "1", "--updates", UPDATES, "--out", str(tmp_path / "alone")]) == 0
    first, second = ((tmp_path / f"c/runs/000{seed}/run.mcap").read_bytes() for seed in (0, 1))
    assert (tmp_path / "alone/run.mcap").read_bytes() == second
    assert len(second) > 100_000  # it holds the scan
    assert first != second
