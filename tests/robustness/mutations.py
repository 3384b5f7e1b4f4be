"""How the fuzz test spoils files: bytes, lines, numbers, words and whole values, all from one seeded generator."""

from __future__ import annotations

import json
import re
from copy import deepcopy
from random import Random
from typing import Any

from ruamel.yaml import YAML

NUMBERS = (
    *("0", "-1", "1e-308", "1e308", "-1e308", "1e10", "1e18", "-2147483649", "2147483648", "18446744073709551616"),
    *("nan", "inf", "-inf", ".nan", ".inf", "1e-45", "3.5e38", "1e-9", "1e999", "0x7fffffff", "9" * 400),
)
WORDS = (
    *(
        "/World/\\ud800",
        "\\ud800",
        "",
        " ",
        "..",
        "../../etc/passwd",
        "/etc/passwd",
        "~",
        "/dev/zero",
        "/proc/self/mem",
    ),
    *("x.usda:SDF_FORMAT_ARGS:a=b", "anon:0x1", "\x1b]0;t\x07", "\u202e", "a" * 5000, "/" * 300, "{}", "[[]]", "null"),
    *(
        "true",
        "execution",
        "token",
        "double[]",
        "matrixd[4][]",
        "any",
        "union",
        "bundle",
        "rel",
        "/World",
        "/World/Box",
    ),
    *("/World/Lidar", "PhysicsRigidBodyAPI", "OmniGraphNode", "Mesh", "GeomSubset", "NurbsPatch", "TetMesh", "Points"),
    *("BasisCurves", "Material", "Camera", "OmniRadar", "PhysxDeformableSurfaceAPI", "timeSamples", "None", "<>", "@@"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 5, 1e308, 1e-308, 1e10, 2**63, 2**64, 10**29, "", " ", "x", [], {}, [[]], [None], {"": 1}),
    *(float("nan"), float("inf"), [1] * 5000, "\x1b[2J", "..", "/World/Lidar", "../../etc/passwd", [[[[[[1]]]]]]),
    *(
        {"type": "Cube"},
        {"type": "any"},
        "double[]",
        ["a", 1, None],
        [1e308, 1e308, 1e308, 1e308],
        "1/0",
        "1e999999999",
    ),
)
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"[A-Za-z_][\w:.]*")


def spoiled(data: bytes, kind: str, random: Random) -> bytes:
    """A file of a kind (its suffix) spoiled a few times over."""
    if kind in (".json", ".yaml", ".ogn") and random.random() < 0.7:
        return _document(data, random)
    ways = (changed_bytes, cut, _doubled, _swapped) if kind in (".usdc", ".mcap") else _TEXT_WAYS
    for _ in range(random.choice((1, 1, 1, 1, 2, 3, 8))):
        data = random.choice(ways)(data, random)
    return data


def _document(data: bytes, random: Random) -> bytes:
    """JSON (which YAML is too) with values, keys and members changed, so that it stays JSON."""
    document = YAML(typ="safe", pure=True).load(data)
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        places = list(_places(document))
        if not places:
            break
        holder, key = random.choice(places)
        what = random.random()
        if what < 0.6:
            holder[key] = deepcopy(random.choice(VALUES))
        elif what < 0.7:
            del holder[key]
        elif what < 0.85:
            other, name = random.choice(places)
            if name in other if isinstance(other, dict) else name < len(other):
                holder[key] = json.loads(json.dumps(other[name]))
        elif isinstance(holder, dict):
            holder[random.choice(WORDS)] = holder.pop(key)
        else:
            holder.insert(key, deepcopy(random.choice(VALUES)))
    text = json.dumps(document)
    return text.encode("utf-8", "surrogatepass")


def _places(value: Any) -> Any:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield value, key
        yield from _places(inner)


def changed_bytes(data: bytes, random: Random) -> bytes:
    """A few bytes overwritten, also by what says a large length."""
    changed = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 4, 16))):
        if not changed:
            break
        at = random.randrange(len(changed))
        new = random.choice((random.randbytes(1), b"\0", b"\xff", random.randbytes(8), b"\xff" * 4, b"\0\0\0\x7f"))
        changed[at : at + len(new)] = new
    return bytes(changed)


def cut(data: bytes, random: Random) -> bytes:
    """A piece taken out, or everything from a place on."""
    if not data:
        return data
    at = random.randrange(len(data))
    return data[:at] + (b"" if random.random() < 0.2 else data[at + random.randrange(1, 64) :])


def _doubled(data: bytes, random: Random) -> bytes:
    """A piece once more, or a hundred times."""
    if not data:
        return data
    at = random.randrange(len(data))
    end = at + random.randrange(1, 200)
    return data[:end] + data[at:end] * random.choice((1, 1, 3, 100)) + data[end:]


def _swapped(data: bytes, random: Random) -> bytes:
    """A piece of the file at another place."""
    if len(data) < 2:
        return data
    at, to, length = random.randrange(len(data)), random.randrange(len(data)), random.randrange(1, 100)
    piece = data[at : at + length]
    return data[:to] + piece + data[to + len(piece) :]


def _number(data: bytes, random: Random) -> bytes:
    """A number replaced by an extreme one."""
    return _replaced(data, _NUMBER, random.choice(NUMBERS), random)


def _word(data: bytes, random: Random) -> bytes:
    """A word replaced by another of the file, or by one of the list."""
    text = data.decode("utf-8", "replace")
    others = _WORD.findall(text) or ["x"]
    return _replaced(data, _WORD, random.choice((random.choice(others), random.choice(WORDS))), random)


def _replaced(data: bytes, what: re.Pattern[str], by: str, random: Random) -> bytes:
    text = data.decode("utf-8", "surrogateescape")
    found = list(what.finditer(text))
    if not found:
        return data
    one = random.choice(found)
    return (text[: one.start()] + by + text[one.end() :]).encode("utf-8", "surrogateescape")


def _line(data: bytes, random: Random) -> bytes:
    """A line taken out, doubled, moved or put inside another."""
    lines = data.split(b"\n")
    at = random.randrange(len(lines))
    what = random.random()
    if what < 0.4:
        del lines[at]
    elif what < 0.7:
        lines.insert(random.randrange(len(lines)), lines[at])
    else:
        to = random.randrange(len(lines))
        lines[at], lines[to] = lines[to], lines[at]
    return b"\n".join(lines)


_TEXT_WAYS = (*[_number] * 6, *[_word] * 8, *[_line] * 4, changed_bytes, cut, _doubled, _swapped)
