"""HTML by which a notebook shows an object, and pages of figures that load nothing and run no script."""

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


_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem; color: #222 }
table { border-collapse: collapse; font-size: 13px; margin: 1rem 0; display: block; overflow-x: auto }
th, td { padding: .25rem .6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap }
th { border-bottom: 1px solid #888 } td.text, th.text { text-align: left }
tr.best td { background: #fdeaea } tr.bad td { color: #999 } pre { background: #f4f4f4; padding: .8rem }
img { max-width: 100%; height: auto }
"""


def page_of(title: str, body: Iterable[str]) -> str:
    """A whole page; body: HTML of its parts. It may load nothing and run no script, whatever its texts hold."""
    policy = f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
    head = f'<meta charset="utf-8">{policy}<title>{escape(title)}</title><style>{_STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(body) + "\n</body></html>\n"


def table_of(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, text: Iterable[int] = (), marks: Sequence[str] = ()
) -> str:
    """A table of a page. text: columns that are not numbers; marks: the class of each row."""
    left = set(text)

    def cells(tag: str, row: Sequence[str]) -> str:
        return "".join(
            f"<{tag}{' class=text' if number in left else ''}>{escape(cell)}</{tag}>" for number, cell in enumerate(row)
        )

    lines = [f'<tr class="{marks[number] if marks else ""}">{cells("td", row)}</tr>' for number, row in enumerate(rows)]
    return f"<table><tr>{cells('th', heads)}</tr>{''.join(lines)}</table>"


def picture(png: bytes, text: str) -> str:
    """A PNG picture, held by the page itself."""
    from base64 import b64encode

    return f'<img alt="{escape(text)}" src="data:image/png;base64,{b64encode(png).decode()}">'
