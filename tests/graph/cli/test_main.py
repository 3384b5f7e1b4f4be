import subprocess
import sys

import pytest

from graph.base.errors import Mark, Problem, RunError, UserError
from graph.cli import main as cli
from graph.cli.commands import every


class Stub:
    """A subcommand that notes its arguments and then does what the test asks."""

    def __init__(self, outcome=0):
        self.outcome = outcome
        self.args = None

    def add_arguments(self, parser):
        parser.add_argument("file", nargs="?")
        parser.add_argument("--flag", action="store_true")
        parser.add_argument("--count", type=int)
        parser.add_argument("--share", type=float)

    def run(self, args):
        self.args = args
        if isinstance(self.outcome, BaseException):
            raise self.outcome
        return self.outcome


@pytest.fixture
def command(monkeypatch):
    """Puts a stub in the place of every subcommand."""

    def install(outcome=0):
        stub = Stub(outcome)
        monkeypatch.setattr(cli, "import_module", lambda name: stub)
        return stub

    return install


def test_help_lists_every_command(capsys):
    assert cli.main(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(f"\n  {name} " in text for name in every())


def test_no_command_prints_the_help(capsys):
    assert cli.main([]) == 0
    assert "commands:" in capsys.readouterr().out


def test_version(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"tickgraph {cli.version()}\n"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["rnu"], 'graph: there is no command "rnu"; did you mean "run"?'),
        (["x"], f'graph: there is no command "x"; commands are {", ".join(every())}'),
        (["--debug"], "graph: no command given; see graph --help"),
        (["--wrong"], "graph: unrecognized arguments: --wrong; see graph --help"),
        (["run", "--wrong"], 'graph run: there is no option "--wrong"; see graph run --help'),
        (["run", "--count", "x"], "graph run: argument --count: 'x' is not a whole number; see graph run --help"),
        (["run", "--share", "x"], "graph run: argument --share: 'x' is not a number; see graph run --help"),
        (["run", "--/a"], "graph: --/a: write a setting as --/path=value"),
        (["run", "--/=1"], "graph: --/=1: write a setting as --/path=value"),
        (["nodes", "--/a=1"], "graph: graph nodes builds no App and takes no settings; leave out --/a"),
    ],
)
def test_a_wrong_command_line_is_one_line_and_exit_2(command, capsys, arguments, line):
    command()
    assert cli.main(arguments) == 2
    out, err = capsys.readouterr()
    assert (out, err) == ("", line + "\n")


def test_settings_are_picked_out_and_read_as_yaml_scalars(command):
    stub = command()
    assert cli.main(["run", "--/a/b=true", "f.yaml", "--/c=1e3", "--flag", "--/d=on", "--/e=", "--/f==x"]) == 0
    assert stub.args.settings == {"/a/b": True, "/c": 1000.0, "/d": "on", "/e": "", "/f": "=x"}
    assert (stub.args.file, stub.args.flag) == ("f.yaml", True)


def test_after_two_dashes_nothing_is_an_option(command):
    stub = command()
    assert cli.main(["run", "--", "--/a=1"]) == 0
    assert stub.args.settings == {}
    assert stub.args.file == "--/a=1"


@pytest.mark.parametrize("arguments", [["--debug", "run", "f"], ["run", "f", "--debug"]])
def test_debug_is_taken_before_and_after_the_command(command, arguments):
    stub = command()
    assert cli.main(arguments) == 0
    assert stub.args.debug is True


def test_the_exit_code_is_the_commands(command):
    command(1)
    assert cli.main(["run"]) == 1


WRONG = UserError([Problem("first.", Mark("a.yaml", 2, 3)), Problem("second\nwith a break and \x1b[31mred.")])


@pytest.mark.parametrize(
    ("outcome", "code", "text"),
    [
        (WRONG, 2, "a.yaml:2:3: first.\ngraph: second with a break and \\u001b[31mred.\n"),
        (RunError("the physics\ndiverged"), 1, "graph: the physics diverged\n"),
        (KeyboardInterrupt(), 130, "graph: interrupted\n"),
        (
            ImportError("libGL.so.1: cannot open shared object file"),
            1,
            "graph: a library cannot be loaded: libGL.so.1: cannot open shared object file; graph doctor says what to "
            "install\n",
        ),
        (
            ZeroDivisionError("oh"),
            1,
            "graph: internal error: ZeroDivisionError: oh; run it again with --debug for the traceback, and report "
            "it\n",
        ),
    ],
)
def test_what_goes_wrong_is_a_line_each_and_an_exit_code(command, capsys, outcome, code, text):
    command(outcome)
    assert cli.main(["run"]) == code
    assert capsys.readouterr().err == text


@pytest.mark.parametrize("outcome", [WRONG, RunError("x"), KeyboardInterrupt(), ValueError("x")])
def test_debug_shows_the_traceback(command, capsys, outcome):
    command(outcome)
    cli.main(["run", "--debug"])
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def python(code, *arguments, **options):
    return subprocess.run(
        [sys.executable, *arguments, "-c", code], capture_output=True, text=True, check=False, **options
    )


HEAVY = "numpy mujoco open3d pxr pydantic ruamel rich networkx mcap rosbags nodes sensors graph.sim"


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["run", "--help"], ["check", "--help"], ["show", "--help"]]
)
def test_help_loads_none_of_the_libraries(arguments):
    code = f"""
import sys
from graph.cli.main import main
main({arguments!r})
print([name for name in {HEAVY!r}.split() if name in sys.modules])
"""
    assert python(code).stdout.splitlines()[-1] == "[]"


def test_python_dash_m_graph_is_the_command():
    result = subprocess.run([sys.executable, "-m", "graph", "rnu"], capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr == 'graph: there is no command "rnu"; did you mean "run"?\n'


def test_a_reader_that_went_away_gives_no_traceback():
    result = subprocess.run(
        f"{sys.executable} -m graph --help | head -c 1 > /dev/null; {sys.executable} -m graph schema | head -c 1",
        shell=True,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stderr == ""


def test_a_character_that_the_terminal_cannot_show_is_escaped():
    code = "from graph.cli.main import main; import sys; sys.exit(main(['k\\u00e4se']))"
    result = python(code, env={"PYTHONIOENCODING": "ascii", "PATH": ""})
    assert result.stderr.startswith('graph: there is no command "k\\xe4se"')


def test_a_folder_to_allow_must_be_there(graph, folder):
    (folder / "a.yaml").write_text("tickgraph: 1\n")
    done = graph("check", "a.yaml", "--allow", "nosuch")
    assert (done.code, done.err.strip()) == (
        2,
        "graph check: argument --allow: nosuch is not a folder; see graph check --help",
    )
