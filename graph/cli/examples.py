"""The shipped example graphs: where they are, what each is about, and which files belong to one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from graph.base.extras import ROOT
from graph.base.suggest import did_you_mean

FOLDERS = ("tickgraph_examples", "graphs")
"""Their folder beside the packages: in an environment, in a checkout."""


def folder() -> Path:
    """The folder of the examples. Raises FileNotFoundError if it does not exist."""
    for name in FOLDERS:
        if (ROOT / name / "quickstart.yaml").is_file():
            return ROOT / name
    raise FileNotFoundError(f"the examples are neither in {ROOT / FOLDERS[0]} nor in {ROOT / FOLDERS[1]}")


def examples() -> dict[str, Path]:
    """The graph files by name, in the order of their names."""
    files = sorted(folder().glob("*.yaml"))
    return {file.stem: file for file in files if not file.name.endswith(".test.yaml") and _is_graph(file)}


def about(file: Path) -> str:
    """The first sentence of a file, from the comment that it begins with."""
    lines = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return re.split(r"(?<=[a-z\d)`])[.:](?:\s|$)", " ".join(lines).strip(), maxsplit=1)[0]


def files_of(example: Path) -> list[Path]:
    """The files of an example: the graph file, its tests, and what these and its scene name in the same folder.

    A list of messages among them (`commands_of`) makes the robot of the example move.
    """
    root = example.parent
    others = [file for file in _every(root) if file.suffix != ".py" and not _is_other_graph(file)]
    tests = example.with_suffix(".test.yaml")
    found = [example, *([tests] if tests.is_file() else [])]
    for file in found:  # which grows
        text = file.read_bytes().decode("utf-8", errors="ignore")
        found += [one for one in others if one not in found and _names(text, one.relative_to(root).as_posix(), one)]
    return found


def commands_of(files: list[Path]) -> Path | None:
    """The list of messages among the files of an example, for `graph run --play`."""
    lists = [file for file in files if file.suffix == ".yaml" and "topic:" in _head(file)]
    return next((file for file in lists if not file.name.endswith(".test.yaml") and not _is_graph(file)), None)


def unknown(name: str, kinds: Mapping[str, str]) -> str:
    """The line for a name that is neither a kind of template nor an example: what is meant by spelling or by content.

    kinds: what each kind of template is.
    """
    contents = {**kinds, **{example: about(file) for example, file in examples().items()}}
    fitting = [one for one, content in contents.items() if _speaks_of(name, f"{one} {content}")]
    if fitting:
        hint = f"; of that {'is' if len(fitting) == 1 else 'are'} {', '.join(fitting)} (graph new --list)"
    else:
        hint = did_you_mean(name, contents, "graph new --list lists them")
    return f'there is no example "{name}"{hint}'


def _speaks_of(name: str, content: str) -> bool:
    """Whether a word of the content begins as the name does, or is the beginning of it (plural, compound)."""
    words = re.findall(r"\w+", content.lower().replace("_", " "))
    folded = name.lower()
    return len(folded) > 2 and any(
        word.startswith(folded) or (len(word) > 3 and folded.startswith(word)) for word in words
    )


def _names(text: str, path: str, file: Path) -> bool:
    return re.search(rf"(?<![\w-])(?:{re.escape(path)}|{re.escape(file.name)})(?![\w.-])", text) is not None


def _every(root: Path) -> Iterator[Path]:
    return (file for file in sorted(root.rglob("*")) if file.is_file() and "__pycache__" not in file.parts)


def _is_other_graph(file: Path) -> bool:
    return file.suffix == ".yaml" and (file.name.endswith(".test.yaml") or _is_graph(file))


def _is_graph(file: Path) -> bool:
    return re.search(r"^tickgraph:", _head(file), re.MULTILINE) is not None


def _head(file: Path) -> str:
    with file.open(encoding="utf-8") as stream:
        return stream.read(4000)
