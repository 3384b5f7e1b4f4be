"""Reads an MJCF model with all files that it names, before MuJoCo sees any of them.

Includes are inserted, every other file that the model names is read, and its name is replaced by one of ours: MuJoCo
then opens no file itself. Each element is written on a line of its own, and no two models of one document share a line
number, so that the line in a message of MuJoCo leads back to a file and a line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

from graph.base import asset_roots
from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import start_of
from graph.base.records import dataclass, field

from . import bounds, urdf
from .source import Element, parse

MAX_FILE = 2**28
"""Bytes of one asset."""
MAX_TOTAL = 2**30
"""Bytes of all assets."""
MAX_INCLUDES = 1000

_FILES = {
    "mesh": ("file",),
    "hfield": ("file",),
    "skin": ("file",),
    "flexcomp": ("file",),
    "texture": ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback"),
}
_SETTLED = ("meshdir", "texturedir", "assetdir", "strippath", "discardvisual", "fusestatic")
"""Compiler attributes that are left out: the first are applied here; the last two would remove what rays should see."""


@dataclass
class Document:
    """A model ready for MuJoCo: its text, the contents of its files, and the origin of each line."""

    file: Path
    text: str = ""
    assets: dict[str, bytes] = field(default_factory=dict)
    models: dict[str, bytes] = field(default_factory=dict)
    """Texts of models that this one can attach, by their names in it."""
    marks: list[Mark] = field(default_factory=list)
    left_out: list[tuple[Mark, str]] = field(default_factory=list)
    """What of a URDF is not read."""
    is_urdf: bool = False
    speeds: dict[str, float] = field(default_factory=dict)
    """Of a URDF: the largest speed of joints by their names [rad/s or m/s]."""

    def mark(self, line: int) -> Mark | None:
        """The place in a file of line `line` (from 1) of one of the texts."""
        return self.marks[line - 1] if 0 < line <= len(self.marks) else None


def read_model(file: Path, roots: Sequence[Path], *, is_urdf: bool = False) -> Document:
    """The model in `file`, MJCF or (`is_urdf`) URDF; its files must be below `roots` or an asset root, links resolved.

    Raises UserError with every problem: files that are missing, outside, too large or not XML; a model that is too
    large.
    """
    allowed = [root.expanduser().resolve() for root in (*roots, *asset_roots.present().values())]
    reader = _Reader(file, allowed, is_urdf)
    document = Document(file, is_urdf=is_urdf, left_out=reader.left_out)
    document.text = reader.model(file, ())[0]
    document.assets, document.models, document.marks = reader.assets, reader.models, reader.marks
    document.speeds = reader.speeds
    if reader.problems:
        raise UserError(reader.problems)
    return document


@dataclass
class _Folders:
    """The folders of a model's assets."""

    model: Path
    mesh: str = ""
    texture: str = ""
    strip: bool = False

    def path(self, tag: str, text: str) -> Path:
        text = text.replace("\\", "/")
        if self.strip:
            text = text.rpartition("/")[2]
        below = {"texture": self.texture, "model": ""}.get(tag, self.mesh)
        return self.model / below.replace("\\", "/") / text


class _Reader:
    def __init__(self, file: Path, roots: list[Path], is_urdf: bool) -> None:
        self.file, self.roots, self.urdf = file, roots, is_urdf
        self.left_out: list[tuple[Mark, str]] = []
        self.speeds: dict[str, float] = {}
        self.problems: list[Problem] = []
        self.assets: dict[str, bytes] = {}
        self.models: dict[str, bytes] = {}
        self.marks: list[Mark] = []
        self._names: dict[Path, str] = {}
        self._models: dict[Path, tuple[str, float, str]] = {}
        self._total = 0

    def model(self, file: Path, above: tuple[Path, ...]) -> tuple[str, float, str]:
        """Text, number of elements and name of a model; `above`: the models being parsed, outermost first."""
        root = parse(file, shown(file))
        self._check_kind(root, file)
        if self.urdf:
            problems, left_out = urdf.prepare(root)
            self.problems += problems
            self.left_out += left_out
            self.speeds = urdf.speed_limits(root)
        else:
            self._include(root, file.parent, file.parent, {file.resolve()})
        folders = _folders(root, file.parent)
        models: dict[str, int] = {}
        for element in root.walk():
            self.problems += bounds.too_large(element)
            if element.tag == "model" and element.get("file"):
                models.update(self._submodel(element, folders, (*above, file.resolve())))
            for attribute in ("filename",) if self.urdf and element.tag == "mesh" else _FILES.get(element.tag, ()):
                if element.get(attribute):
                    self._asset(element, attribute, folders)
        size = bounds.elements(root, models)
        if size > bounds.MAX_ELEMENTS:
            message = f"replication and attachment make {size:.0f} elements of it, above {bounds.MAX_ELEMENTS}"
            raise UserError([*self.problems, Problem(message, root.mark)])
        first = len(self.marks)
        lines = list(self._lines(root))
        return "\n" * first + "\n".join(lines), size, root.get("model") or ""

    def _check_kind(self, root: Element, file: Path) -> None:
        wanted = "robot" if self.urdf else "mujoco"
        if root.tag == wanted:
            return
        hint = f"{'a URDF' if self.urdf else 'an MJCF model'} starts with <{wanted}>"
        if root.tag in ("robot", "mujoco"):
            said, key = ("a URDF", "urdf") if root.tag == "robot" else ("an MJCF model", "mjcf")
            hint = f"this is {said}; name it as scene: {{{key}: {file.name}}}"
        raise UserError(Problem(f"the root element is <{root.tag}>; {hint}", root.mark))

    def _include(self, parent: Element, main: Path, folder: Path, seen: set[Path]) -> None:
        children: list[Element] = []
        for child in parent.children:
            if child.tag != "include":
                self._include(child, main, folder, seen)
                children.append(child)
                continue
            text = (child.get("file") or "").replace("\\", "/")
            if not text:
                self.problems.append(Problem("include: it names no file", child.mark))
                continue
            # As in MuJoCo: below the main file's folder, else below that of the file which includes.
            path = main / text if (main / text).exists() else folder / text
            if self._refused(path, child, "include", text):
                continue
            if path.resolve() in seen or len(seen) > MAX_INCLUDES:
                self.problems.append(Problem(f"include: {text} is included already; a file may be so once", child.mark))
                continue
            seen.add(path.resolve())
            included = parse(path, shown(path))
            self._include(included, main, path.parent, seen)
            children += included.children
        parent.children = children

    def _submodel(self, element: Element, folders: _Folders, above: tuple[Path, ...]) -> dict[str, int]:
        """The number of elements of an attachable model, by its names."""
        text = element.attributes["file"]
        path = folders.path("model", text)
        if self._refused(path, element, _said(element), text):
            return {}
        path = path.resolve()
        if path in above:
            self.problems.append(Problem(f"{_said(element)}: {text} attaches itself", element.mark))
            return {}
        if path not in self._models:
            self._models[path] = self.model(path, above)
            self.models[self._name(path)] = self._models[path][0].encode()
        element.attributes["file"] = self._name(path)
        _, size, name = self._models[path]
        return {element.get("name") or name: int(size)}

    def _asset(self, element: Element, attribute: str, folders: _Folders) -> None:
        text = element.attributes[attribute]
        try:
            path = self._mesh(text, folders) if self.urdf else folders.path(element.tag, text)
        except ValueError as error:
            self.problems.append(Problem(f"{_said(element)}: {error}", element.mark))
            return
        if self._refused(path, element, _said(element), text):
            return
        if attribute == "file" and element.tag not in ("flexcomp", "skin"):
            element.attributes.setdefault("name", Path(text.replace("\\", "/")).stem)
        path = path.resolve()
        name = self._name(path)
        if name not in self.assets:
            data = start_of(path, MAX_TOTAL + 1)
            self._total += len(data)
            if self._total > MAX_TOTAL:
                raise UserError(Problem(f"its assets are larger than {MAX_TOTAL >> 30} GiB", element.mark))
            width, height = bounds.image_size(data) or (0, 0)
            if width * height > bounds.MAX_PIXELS:
                message = f"{_said(element)}: {text} has {width} by {height} pixels, above {bounds.MAX_PIXELS}"
                self.problems.append(Problem(message, element.mark))
                return
            self.assets[name] = data
        element.attributes[attribute] = name

    def _mesh(self, text: str, folders: _Folders) -> Path:
        return urdf.mesh_file(text, self.file, folders.model / folders.mesh, self.roots)

    def _refused(self, path: Path, element: Element, what: str, text: str) -> bool:
        """Records why a file cannot be read, if so."""
        try:
            real = path.resolve()
            outside = not any(real.is_relative_to(root) for root in self.roots)
            missing, large = not real.is_file(), real.is_file() and real.stat().st_size > MAX_FILE
        except (OSError, ValueError, RuntimeError):
            outside, missing, large = False, True, False
        if outside:
            reason = "lies outside the model's folders; move it there, or allow its folder with --allow"
        elif missing:
            reason = f"there is no such file (looked for {shown(path)})"
        elif large:
            reason = f"is larger than {MAX_FILE >> 20} MiB"
        else:
            return False
        joint = ": " if missing and not outside else " "
        self.problems.append(Problem(f"{what}: {text}{joint}{reason}", element.mark))
        return True

    def _name(self, path: Path) -> str:
        """The name of a file for MuJoCo."""
        if path not in self._names:
            self._names[path] = f"{len(self._names)}-{path.name}"
        return self._names[path]

    def _lines(self, element: Element) -> Iterator[str]:
        self.marks.append(element.mark)
        values = element.attributes
        if element.tag == "compiler":
            values = {name: value for name, value in values.items() if name not in _SETTLED}
            values |= urdf.KEPT if self.urdf else {}
        attributes = "".join(f" {name}={quoteattr(value)}" for name, value in values.items())
        if not element.children:
            yield f"<{element.tag}{attributes}/>"
            return
        yield f"<{element.tag}{attributes}>"
        for child in element.children:
            yield from self._lines(child)
        self.marks.append(element.mark)
        yield f"</{element.tag}>"


def shown(path: Path) -> str:
    """A path as messages name it: relative to the working directory if it lies below it."""
    try:
        return str(path.relative_to(Path.cwd()))
    except ValueError:
        return str(path)


def _folders(root: Element, folder: Path) -> _Folders:
    out = _Folders(folder)
    groups = [root, *(child for child in root.children if child.tag == "mujoco")]
    for compiler in (child for group in groups for child in group.children if child.tag == "compiler"):
        both = compiler.get("assetdir")
        out.mesh = compiler.get("meshdir") or both or out.mesh
        out.texture = compiler.get("texturedir") or both or out.texture
        if compiler.get("strippath"):
            out.strip = compiler.get("strippath") == "true"
    return out


def _said(element: Element) -> str:
    name = element.get("name")
    return f"{element.tag} {name}" if name else element.tag
