"""HTML by which a notebook shows an object."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], caption: str) -> str:
    """A table of texts; the caption stands above it."""
    lines = [f"<table><caption>{escape(caption)}</caption><thead><tr>"]
    lines += [f"<th>{escape(one)}</th>" for one in headings]
    lines.append("</tr></thead><tbody>")
    lines += [f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return "".join([*lines, "</tbody></table>"])


def figure(png: bytes, caption: str) -> str:
    """A PNG picture, held by the page itself, with a caption."""
    from base64 import b64encode

    text = escape(caption)
    source = f"data:image/png;base64,{b64encode(png).decode()}"
    return f'<figure><img src="{source}" alt="{text}"><figcaption>{text}</figcaption></figure>'
