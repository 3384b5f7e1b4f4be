import pytest

from graph.files import examine


@pytest.fixture
def usda(tmp_path):
    """Writes a USD text file (header added) and returns its path."""

    def write(body, name="scene.usda", head=""):
        path = tmp_path / name
        path.write_text(f"#usda 1.0\n({head})\n{body}", encoding="utf8")
        return path

    return write


@pytest.fixture
def read(usda):
    """The examined file of a body of USD text."""

    def read(body, **options):
        return examine(usda(body, **options))

    return read
