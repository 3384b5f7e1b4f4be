"""Campaign files: what `graph sweep` takes on its command line, as YAML that is checked like a graph file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from graph.base.errors import Problem, UserError
from graph.base.forms import KEY, Check, Error, Field, Form, FormError, Refused
from graph.base.records import dataclass, field
from graph.base.suggest import did_you_mean
from graph.files import paths
from graph.files.messages import wanted
from graph.files.source import Source
from graph.files.source import read as read_source
from graph.files.text import described
from graph.files.tree import Map, offset, value_at
from graph.session.varied import Varied, read_varied, word_of

from .measuring import parsed
from .points import FILE, JOIN, check_key, check_value, read_table
from .table import TAKEN, taken

KIND = "campaign"
"""The kind of these files, and their first key."""
VERSION = 1


def _key(name: str) -> str:
    if FILE in name.split(JOIN):
        raise Refused("graph files are named under files")
    try:
        check_key(name)
    except ValueError as error:
        raise Refused(str(error)) from None
    return name


def _values(value: Any) -> Any:
    if isinstance(value, dict) or value is None or (isinstance(value, list) and not value):
        raise Refused(f"must be values such as 1,2,5 or 0..99, or a list of them, found {described(value)}")
    return value


def _metric(value: Any) -> str:
    if not isinstance(value, str | int | float) or isinstance(value, bool):
        raise Refused(f"must be an expression, found {described(value)}")
    try:
        parsed(str(value))
    except ValueError as error:
        raise Refused(str(error)) from None
    return str(value)


_ANY_VALUES = {"type": ["string", "number", "boolean", "array"]}
Key = Annotated[str, Check(_key, {"type": "string"})]
Values = Annotated[Any, Check(_values, _ANY_VALUES)]
Expression = Annotated[str, Check(_metric, {"type": ["string", "number"]})]


class CampaignFile(Form):
    """A campaign: graph files, the values that its runs vary, and the metrics."""

    campaign: Literal[1] = Field(description="Version of the file format.")
    files: list[str] = Field(description="Graph files, relative to the campaign file and below its folder.")
    vary: dict[Key, Values] = Field(
        default_factory=dict,
        description="Values by key: a list, or text as of --vary: 1,2,5 or 0..99 or uniform(0, 1)*20. Every "
        "combination is run.",
    )
    points: str | None = Field(
        default=None, description="CSV file of points: keys in the first line, a point in each other."
    )
    fixed: dict[Key, Values] = Field(default_factory=dict, description="Values that all runs have, by key.")
    metrics: dict[str, Expression] = Field(
        default_factory=dict, description="Expressions over report and topics by name."
    )
    vary_seed: int = Field(default=0, description="Seed of the values that `vary` draws.")


@dataclass(frozen=True, slots=True)
class Asked:
    """What a campaign file or a command line asks for."""

    files: tuple[str, ...] = ()
    varied: tuple[Varied, ...] = ()
    rows: tuple[Mapping[str, str], ...] = ()
    fixed: Mapping[str, str] = field(default_factory=dict)
    metrics: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0
    read: tuple[Path, ...] = ()
    """Other files that decide about the points."""


def read_campaign(path: Path, allow: Sequence[Path] = ()) -> Asked:
    """What a campaign file asks for; it names files below its folder and those allowed.

    Raises UserError with every mistake, at its line and column.
    """
    from graph.files.yaml_text import parse

    source = read_source(path, str(path))
    problems: list[Problem] = []
    root, at = parse(source, problems)
    if not isinstance(root, Map):
        problems.append(source.problem(at, f"a campaign is a mapping, found {described(root)}"))
        raise UserError(problems)
    try:
        form = CampaignFile.read(root)
    except FormError as error:
        raise UserError([*problems, *_problems(error.errors, source, root)]) from None

    def wrong(location: tuple[str | int, ...], message: str) -> None:
        problems.append(source.problem(offset(root, location), message))

    folder = path.absolute().parent
    files: list[str] = []
    if not form.files:
        wrong(("files",), "files is empty; name a graph file")
    for index, name in enumerate(form.files):
        try:
            paths.confined(name, folder, allow)
            files.append(str(path.parent / name))
        except ValueError as error:
            wrong(("files", index), f"files: {error}")
    varied: list[Varied] = []
    for key, value in form.vary.items():
        try:
            texts = [word_of(one) for one in value] if isinstance(value, list) else None
            found = Varied(key, tuple(texts)) if texts else read_varied(key, word_of(value), form.vary_seed)
            for text in found.values:
                check_value(key, text)
            varied.append(found)
        except ValueError as error:
            wrong(("vary", key), f"vary: {key}: {error}")
        if key in form.fixed:
            wrong(("fixed", key), f"fixed: {key} is varied too; leave it out of one of them")
    for key, value in form.fixed.items():
        try:
            check_value(key, word_of(value))
        except ValueError as error:
            wrong(("fixed", key), f"fixed: {key}: {error}")
    rows, read = [], [path]
    if form.points is not None:
        try:
            table = paths.confined(form.points, folder, allow)
            rows = read_table(path.parent / form.points)
            read.append(table)
            for key in dict.fromkeys(key for row in rows for key in row if key in form.vary or key == FILE):
                given = "files" if key == FILE else "vary"
                wrong(("points",), f"points: its column {key} is given under {given} too; leave it out of one of them")
        except ValueError as error:
            wrong(("points",), f"points: {error}")
        except UserError as error:
            problems += error.problems
    for name in taken(form.metrics, [*form.vary, *(key for row in rows for key in row)]):
        wrong(("metrics", name), f"metrics: {name}: {TAKEN}")
    if problems:
        raise UserError(problems)
    fixed = {key: word_of(value) for key, value in form.fixed.items()}
    return Asked(tuple(files), tuple(varied), tuple(rows), fixed, form.metrics, form.vary_seed, tuple(read))


def _problems(errors: Iterable[Error], source: Source, root: Map) -> list[Problem]:
    found = []
    for error in errors:
        location = tuple(one for one in error.location if one != KEY)
        about_key = error.location[-1:] == (KEY,) or error.kind == "unknown"
        at = offset(root, location, key=about_key or error.kind == "missing")
        name = ".".join(map(str, location))
        value = described(value_at(root, location))
        match error.kind:
            case "unknown":
                text = f'unknown key "{location[-1]}"{did_you_mean(str(location[-1]), CampaignFile.fields)}'
            case "missing":
                text = f'"{name}" is missing; add it'
            case "refused":
                text = f"{name} {error.detail}" if str(error.detail).startswith("must ") else f"{name}: {error.detail}"
            case "choice":
                text = f"{name} must be {VERSION}, the version of the file format, found {value}"
            case kind:
                text = f"{name} must be {wanted(kind)}, found {value}"
        found.append(source.problem(at, text))
    return found
