"""The pages beside the code name what is there."""

import re

import pytest

from tests.support.manual import cells_of
from tests.support.places import PACKAGES, ROOT
from tests.support.without_wing import is_missing


def folders(package):
    """Without those of which only Python's own files are left."""
    rooms = (path for path in (ROOT / package).iterdir() if path.is_dir() and path.name[0] not in "_.")
    return {path.name for path in rooms if any(one.name != "__pycache__" for one in path.iterdir())}


def listed(page):
    """The names in backquotes in the first column of the page's first table."""
    rows = re.findall(r"^\| (`.*?`) \|", (ROOT / page).read_text(encoding="utf8"), flags=re.MULTILINE)
    return {name for row in rows for name in re.findall(r"`(\w+)`", row)}


@pytest.mark.parametrize("package", ["graph", "graph/sim", "nodes", "wings", "tests"])
def test_the_page_of_a_package_has_a_line_for_each_of_its_rooms(package):
    assert folders(package) <= listed(f"{package}/README.md")


def test_the_files_that_the_contributing_page_names_are_there():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf8")
    named = re.findall(r"`([\w./-]+/[\w.-]+\.(?:py|md|json))[` ]", text)
    assert [name for name in named if not (ROOT / name).exists() and "NAME" not in name and not is_missing(name)] == []
    assert len(named) > 25


PAGES = [
    *ROOT.glob("*.md"),
    *(path for name in (*PACKAGES, "tests") for path in (ROOT / name).rglob("*.md")),
]


def anchors(page):
    """What links to the headings of a page end with, as GitHub makes them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf8"), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def dead_links(page):
    """The links of a page that lead nowhere in the repository."""
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf8")):
        place, _, anchor = target.partition("#")
        if place.startswith("https://"):
            continue
        to = page.parent / place if place else page
        if not to.exists() or (anchor and anchor not in anchors(to)):
            yield target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_links_of_a_page_lead_somewhere(page):
    assert list(dead_links(page)) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_cells_of_tables_are_short(page):
    """What needs more words stands in a paragraph below the table."""
    rows = re.findall(r"^\|.*\|$", page.read_text(encoding="utf8"), re.MULTILINE)
    assert [cell for row in rows for cell in cells_of(row) if len(cell) > 220] == []


def test_a_page_of_the_manual_links_to_pages_of_the_manual_alone():
    """They ship without the rest of the repository."""
    for page in (ROOT / "graph/manual").glob("*.md"):
        links = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf8"))
        assert [link for link in links if "/" in link and not link.startswith("https://")] == []


def test_the_page_of_the_tests_has_a_row_for_each_trap_and_each_helper():
    page = (ROOT / "tests/README.md").read_text(encoding="utf8")
    tests = (ROOT / "tests/graph/sim/timing/test_clock_settings.py").read_text(encoding="utf8")
    assert re.findall(r"^\| (\d+) \|", page, re.MULTILINE) == re.findall(r"def test_trap_(\d+)_", tests)
    helpers = {path.stem for path in (ROOT / "tests/support").glob("[a-z]*.py")}
    assert [name for name in sorted(helpers) if f"`{name}`" not in page] == []


def test_the_pictures_are_there_and_small():
    """At most 300 kB each and 2 MB together; the pages show no others."""
    images = {path.name: path.stat().st_size for path in (ROOT / ".github" / "images").iterdir()}
    made = ("yard", "lidar", "radar", "depth-labels", "clocks", "trade", "campaign", "live")
    assert images.keys() == {f"{name}.png" for name in made}
    assert max(images.values()) <= 300_000
    assert sum(images.values()) <= 2_000_000
    shown = set(re.findall(r"\.github/images/([\w.-]+)", (ROOT / "README.md").read_text(encoding="utf8")))
    assert shown <= images.keys()
