"""Environment variables and files that a graph may read, as far as the user allows.

A graph file may be untrusted, so the file itself cannot allow anything.
"""

from __future__ import annotations

import os
from pathlib import Path

from graph.base.inputs import start_of
from graph.node import Attribute, Database, node_type

ALLOWED = "TICKGRAPH_ALLOW_ENV"
"""The environment variable by which the user names, separated by commas, the variables that graphs may read."""

LARGEST = 64 * 2**20
"""Most bytes of a file that is read."""


@node_type(
    "isaacsim.core.nodes.IsaacReadEnvVar",
    version=1,
    volatile=True,
    inputs={"envVar": Attribute("string", "name of an environment variable", default="")},
    outputs={"value": Attribute("string", "its value; empty where it is not set or not allowed", default="")},
)
def read_environment_variable(db: Database) -> None:
    """Read an environment variable that the user allows: TICKGRAPH_ALLOW_ENV holds their names, with commas between.

    Any other variable reads as empty, with a warning.
    """
    name = db.inputs.envVar
    if name and name not in {each.strip() for each in os.environ.get(ALLOWED, "").split(",")}:
        db.warn("environment-not-allowed", f"{name} is not read; start with {ALLOWED}={name} in the environment")
        name = ""
    db.outputs.value = os.environ.get(name, "") if name else ""


@node_type(
    "isaacsim.core.nodes.IsaacReadFilePath",
    version=1,
    volatile=True,
    inputs={"path": Attribute("path", "the file; a relative path starts at the graph file's folder", default="")},
    outputs={"fileContents": Attribute(("string", "token"), "the text of the file", default="")},
    resolve=lambda known: {"fileContents": "string"},
)
def read_file_path(db: Database) -> bool:
    """Read a text file (UTF-8, 64 MB at most) below the graph file's folder or one that the user allows.

    Without a path, or for a missing file, the text is empty and the node warns; other folders are refused.
    """
    db.outputs.fileContents = ""
    wanted = db.inputs.path
    if not wanted:
        db.warn("file-missing", "input path is empty, so is the text")
        return False
    path = _allowed(db, wanted)
    if not path.is_file():
        db.warn("file-missing", f"there is no file {wanted}; the text is empty")
        return False
    try:
        data = start_of(path, LARGEST + 1)
        if len(data) > LARGEST:
            db.fail(f"{wanted} is larger than {LARGEST // 2**20} MB")
        db.outputs.fileContents = data.decode("utf-8")
    except UnicodeDecodeError:
        db.fail(f"{wanted} is not UTF-8 text")
    except OSError as error:
        db.fail(f"{wanted} cannot be read: {error.strerror}")
    return True


def _allowed(db: Database, wanted: str) -> Path:
    """The file, with links resolved. Fails the node if it lies outside all allowed folders."""
    folders: list[Path] = [folder.resolve() for folder in db.app.folders or ()]
    if not folders or "\0" in wanted:
        db.fail(f"{wanted!r} is not read: this graph was not loaded from a file, so no folder is allowed")
    path = (folders[0] / wanted).resolve()
    if not any(path.is_relative_to(folder) for folder in folders):
        db.fail(f"{wanted} lies outside {folders[0].name}/, the graph file's folder; allow its folder or copy the file")
    return path
