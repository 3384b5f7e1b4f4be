"""Texts joined, searched, cut and changed."""

from __future__ import annotations

import itertools
from collections.abc import Callable

from graph.node import Attribute, Database, node_type

from .like_inputs import joined_text, same_type
from .numbers import check_lengths

TEXT = ("string", "token")
_FORMS: dict[str, Callable[[str], str]] = {
    "UpperCase": str.upper,
    "LowerCase": str.lower,
    "Capitalize": lambda text: text[:1].upper() + text[1:],
    "Title": lambda text: " ".join(word[:1].upper() + word[1:] for word in text.split(" ")),
}


@node_type(
    "omni.graph.nodes.StartsWith",
    version=1,
    inputs={
        "prefix": Attribute("string", "what it may begin with", default=""),
        "value": Attribute("string", "the text", default=""),
    },
    outputs={"isPrefix": Attribute("bool", "whether it does")},
)
def starts_with(db: Database) -> None:
    """Give whether a text begins with another."""
    db.outputs.isPrefix = db.inputs.value.startswith(db.inputs.prefix)


@node_type(
    "omni.graph.nodes.EndsWith",
    version=1,
    inputs={
        "suffix": Attribute("string", "what it may end with", default=""),
        "value": Attribute("string", "the text", default=""),
    },
    outputs={"isSuffix": Attribute("bool", "whether it does")},
)
def ends_with(db: Database) -> None:
    """Give whether a text ends with another."""
    db.outputs.isSuffix = db.inputs.value.endswith(db.inputs.suffix)


@node_type(
    "omni.graph.nodes.CapitalizeString",
    version=1,
    inputs={
        "operation": Attribute(
            "token", "how to write it", default="UpperCase", literal_only=True, allowed_tokens=tuple(_FORMS)
        ),
        "string": Attribute(TEXT, "the text"),
    },
    outputs={"string": Attribute(TEXT, "the text in that form")},
    resolve=same_type("string", "string"),
)
def capitalize_string(db: Database) -> None:
    """Convert a text to upper or lower case, or start it (Capitalize) or each of its words (Title) with a capital."""
    db.outputs.string = _FORMS[db.inputs.operation](db.inputs.string)


@node_type(
    "omni.graph.nodes.GetStringLength",
    version=1,
    inputs={"string": Attribute(TEXT, "the text")},
    outputs={"length": Attribute("int", "its characters")},
)
def get_string_length(db: Database) -> None:
    """Count the characters of a text."""
    db.outputs.length = len(db.inputs.string)


@node_type(
    "omni.graph.nodes.FindString",
    version=1,
    inputs={
        "pos": Attribute("int", "where to begin, from 0", default=0, minimum=0),
        "string": Attribute(TEXT, "the text to look in"),
        "value": Attribute(TEXT, "the text to look for"),
    },
    outputs={"index": Attribute("int", "where it first stands; -1 where it does not")},
)
def find_string(db: Database) -> None:
    """Find a text in another."""
    db.outputs.index = db.inputs.string.find(db.inputs.value, max(db.inputs.pos, 0))


@node_type(
    "omni.graph.nodes.InsertString",
    version=1,
    inputs={
        "index": Attribute("int", "before which character; one beyond either end means that end", default=0),
        "string": Attribute(TEXT, "the text"),
        "value": Attribute(TEXT, "what goes into it"),
    },
    outputs={"string": Attribute(TEXT, "both together")},
    resolve=same_type("string", "string"),
)
def insert_string(db: Database) -> None:
    """Put a text into another."""
    text, value = db.inputs.string, db.inputs.value
    index = min(max(db.inputs.index, 0), len(text))
    db.claim((len(text) + len(value)) * 4)
    db.outputs.string = text[:index] + value + text[index:]


@node_type(
    "omni.graph.nodes.ReplaceString",
    version=1,
    inputs={
        "replace": Attribute(TEXT, "what to replace"),
        "replaceAll": Attribute("bool", "whether to replace it wherever it stands", default=False),
        "string": Attribute(TEXT, "the text"),
        "value": Attribute(TEXT, "what to put there; an empty one takes it out"),
    },
    outputs={"string": Attribute(TEXT, "the text with the other in its place")},
    resolve=same_type("string", "string"),
)
def replace_string(db: Database) -> None:
    """Replace a part of a text, its first occurrence or all; an empty part is not found."""
    text, part, value = db.inputs.string, db.inputs.replace, db.inputs.value
    count = text.count(part) if part and db.inputs.replaceAll else 1 if part else 0
    db.claim((len(text) + count * len(value)) * 4)
    db.outputs.string = text.replace(part, value, count)


@node_type(
    "omni.graph.nodes.SplitString",
    version=1,
    inputs={
        "delimiter": Attribute("string", "what stands between the parts", default=""),
        "string": Attribute("string", "the text", default=""),
    },
    outputs={"elements": Attribute("token[]", "its parts, in order")},
)
def split_string(db: Database) -> None:
    """Split a text at a delimiter; without a delimiter it is a single part."""
    text, delimiter = db.inputs.string, db.inputs.delimiter
    db.outputs.elements = text.split(delimiter) if delimiter else [text]


@node_type(
    "omni.graph.nodes.IsEmpty",
    version=1,
    inputs={"input": Attribute("any", "a text or an array")},
    outputs={"isEmpty": Attribute("bool", "whether there is nothing in it")},
)
def is_empty(db: Database) -> None:
    """Give whether a text has no characters or an array no elements; a number or tuple is never empty."""
    value, kind = db.inputs.input, str(db.input_type("input"))
    counted = isinstance(value, (str, list, dict)) or kind.endswith("[]")
    db.outputs.isEmpty = counted and len(value) == 0


TEXTS = ("string", "token", "token[]")


@node_type(
    "omni.graph.nodes.BuildString",
    version=2,
    inputs={"a": Attribute(TEXTS, "the start"), "b": Attribute(TEXTS, "what follows")},
    outputs={"value": Attribute(TEXTS, "all of it, of the type of a; an array where one of them is")},
    dynamic_inputs={"{operand}": Attribute(TEXTS, "what follows then")},
    resolve=joined_text,
)
def build_string(db: Database) -> None:
    """Join texts; arrays element by element, with a single text repeated for each."""
    parts = [db.inputs.a, db.inputs.b, *db.dynamic_inputs()]
    arrays = [part for part in parts if isinstance(part, list)]
    if not arrays:
        db.claim(sum(map(len, parts)) * 4)
        db.outputs.value = "".join(parts)
        return
    check_lengths(db, arrays)
    rows = [part if isinstance(part, list) else [part] * len(arrays[0]) for part in parts]
    db.claim(sum(map(len, itertools.chain.from_iterable(rows))) * 4)
    db.outputs.value = ["".join(row) for row in zip(*rows, strict=True)]
