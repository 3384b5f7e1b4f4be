import pytest

from graph.cli.main import main


@pytest.fixture
def run_script(tmp_path, capsys):
    """Runs a script by `graph exec`; gives exit code, stdout and stderr."""

    def run(text, *options, arguments=(), name="script.py"):
        file = tmp_path / name
        file.write_text(text)
        code = main(["exec", *map(str, options), str(file), *arguments])
        told = capsys.readouterr()
        return code, told.out, told.err

    return run
