"""`graph help`: the list of pages, a page, a command, a word that is neither."""

import io
import os
import subprocess
import sys

import pytest
from rich.console import Console

from graph.cli.commands import every
from graph.cli.help import column_widths, rendered
from graph.cli.main import main
from graph.manual import ORDER, page
from tests.support.places import ROOT


def test_the_list_has_a_line_for_each_page(capsys):
    assert main(["help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition("\t")[0] for line in lines[: len(ORDER)]] == list(ORDER)
    assert f"lidar\t{page('lidar').line}" in lines


def test_into_a_pipe_a_page_is_markdown_with_commands_for_links(capsys):
    assert main(["help", "python"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("# Python\n\n")
    assert "the annotators of Replicator (`graph help lidar`)" in out  # the link is in brackets of its own
    assert "nodes and tests (`graph help nodes-and-tests`)" in out
    assert "```python\nfrom graph.sim import App\n" in out


def test_marks_of_generated_parts_are_not_printed(capsys):
    assert main(["help", "robustness"]) == 0
    out = capsys.readouterr().out
    assert "<!--" not in out
    assert "| `lidar.bins` | 10,000 spans |" in out


@pytest.mark.parametrize("name", [name for name in every() if name not in ORDER])
def test_a_command_that_is_no_topic_prints_its_section(capsys, name):
    assert main(["help", name]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"## graph {name}\n")
    assert f"`graph {name} --help`" in out


@pytest.mark.parametrize(
    ("topic", "said"),
    [
        ("lidr", 'there is no page "lidr"; did you mean "lidar"?'),
        ("Lidar", 'there is no page "Lidar"; did you mean "lidar"?'),
        ("acoustic", 'there is no page "acoustic"; the word stands on other-sensors'),
        ("bodies", 'there is no page "bodies"; the word stands on '),
        ("zzzz", 'there is no page "zzzz"; graph help lists the pages'),
        ("../limits", 'there is no page "../limits"'),
    ],
)
def test_a_word_that_is_no_topic_is_one_line_and_exit_2(capsys, topic, said):
    assert main(["help", topic]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("topic", ORDER)
def test_a_page_fits_a_terminal_of_80_columns(topic):
    """Every word of its tables is printed, none is cut off with an ellipsis."""
    out = io.StringIO()
    Console(file=out, width=80, force_terminal=False).print(rendered(page(topic).text))
    text = out.getvalue()
    assert max(map(len, text.splitlines())) <= 80
    assert "…" not in text


def test_columns_keep_their_longest_word_and_share_what_is_left():
    columns = [["what", "range"], ["knob", "lidar.motion=continuous"], ["text", "one two three four five six seven"]]
    # 3 gaps of 2; words of 5, 23 and 5 letters: 38 - 6 - 33 = -1, so the longest word is broken
    assert column_widths(columns, 38) == [5, 22, 5]
    # 10 more than the words need: all for the last column, whose text has 33 letters
    assert column_widths(columns, 49) == [5, 23, 15]
    assert column_widths(columns, 80) == [5, 23, 33]


HEAVY = ("numpy", "mujoco", "open3d", "pxr", "numba", "matplotlib", "plotly", "rich", "pydantic")


@pytest.mark.parametrize("words", ["help", "help lidar", "help run", "--help", "new --list", "new lidar scan.yaml"])
def test_help_and_new_load_nothing_heavy(tmp_path, words):
    code = f"import sys; from graph.cli.main import main; main({words.split()}); print(sys.modules.keys() & {HEAVY})"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "set()"


@pytest.mark.parametrize("name", every())
def test_the_options_of_a_command_name_its_page(capsys, name):
    assert main([name, "--help"]) == 0
    assert " ".join(capsys.readouterr().out.split()).endswith(f"The manual: graph help {name}")
