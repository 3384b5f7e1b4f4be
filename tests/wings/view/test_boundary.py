"""Whatever numbers and names a recording holds, its page is JSON of finite numbers, and its names stay texts."""

import json
import re
import resource
import shutil
import struct
from dataclasses import replace
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph.cli.main import main
from graph.recording.run_reader import open_run
from tests.robustness import recordings
from tests.support.browser import browse
from wings.view import writing
from wings.view.boundary import embedded, plain, policy
from wings.view.writing import write_view

SETTINGS = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
NUMBERS = st.one_of(
    st.floats(width=32), st.sampled_from([float("inf"), float("-inf"), float("nan"), 3.4e38, -3.4e38, 1e-45])
)
NASTY = "<a href=https://example.org>x</a>&lt;b&gt;<b>y</b>"


def page_of(file, out):
    """The data of a recording's page, read as strict JSON."""
    with open_run(file) as run:
        sizes = dict.fromkeys(run.recorded, 100.0)
        write_view(run, sizes, {}, "", out, 6.0)
    text = re.search(r'<script id="data"[^>]*>(.*?)</script>', (out / "view.html").read_text(), re.DOTALL)[1]

    def refuse(constant):
        raise AssertionError(constant)

    return json.loads(text, parse_constant=refuse)


@SETTINGS
@given(st.lists(st.tuples(st.integers(0, 35), st.integers(0, 60), NUMBERS), max_size=12), st.integers(0, 2**64 - 1))
def test_any_values_and_times_give_a_page(tmp_path, monkeypatch, changes, log_ns):
    monkeypatch.setattr(writing, "plotly_code", lambda: "")
    said = [replace(one, log_ns=max(log_ns, one.log_ns)) for one in recordings.messages()]
    for place, word, number in changes:
        data = bytearray(said[place].data)
        at = 4 + 4 * word
        if at + 4 <= len(data):
            data[at : at + 4] = struct.pack("<f", number)
        said[place] = replace(said[place], data=bytes(data))
    file = tmp_path / "run.mcap"
    file.write_bytes(recordings.made("rich.mcap", said, Random(0), right=True))
    shutil.rmtree(tmp_path / "out", ignore_errors=True)
    code = None
    try:
        assert page_of(file, tmp_path / "out")["topics"]
    except Exception as error:  # a damaged length makes a message that cannot be decoded: one line of the command
        code = type(error).__name__
    assert code in (None, "RunError", "UserError")


@pytest.mark.parametrize(
    ("value", "safe"),
    [
        (float("inf"), None),
        (float("nan"), None),
        (1e308, 1e308),
        (2**64, 2**53),
        (-(2**64), -(2**53)),
        (True, True),
        ("a\nb\x1b[2J\u202e", "a b\\u001b[2J\\u202e"),
        ({"a\n": (1, [float("-inf")])}, {"a ": [1, [None]]}),
    ],
)
def test_values_become_what_json_holds(value, safe):
    assert plain(value) == safe
    assert json.loads(embedded(value)) == safe


def test_the_policy_names_scripts_by_their_hash_alone():
    """printf 'alert(1)' | openssl dgst -sha256 -binary | base64"""
    said = policy("alert(1)")
    assert "script-src 'sha256-bhHHL3z2vDgxUt0W3dWQOrprscmda2Y5pLsLg4GF+pI='" in said
    assert said.startswith("default-src 'none'")
    assert "unsafe-eval" not in said
    assert "http" not in said


@pytest.mark.skipif(
    shutil.which("chromium") is None or resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY,
    reason="needs the browser chromium, and address space for it",
)
def test_a_page_of_hostile_names_and_numbers_is_drawn_as_text(tmp_path):
    """Topics, frames and joints named as links; an infinite range: no link, no request, no complaint."""
    said = [
        replace(one, topic=f"/{NASTY}{one.topic}", data=one.data.replace(b"lidar\0", b"<b>x\0\0"))
        for one in recordings.messages()
    ]
    file = tmp_path / "run.mcap"
    file.write_bytes(recordings.made("rich.mcap", said, Random(0), right=True))
    assert main(["view", str(file), "--out", str(tmp_path / "out")]) == 0
    with browse(tmp_path / "out/view.html", tmp_path / "profile") as page:
        page.wait_for("document.querySelector('.js-plotly-plot .main-svg')")
        assert page.value("document.querySelectorAll('main a[href]:not([href^=\"#\"]), main svg a').length") == 0
        assert page.complaints() == []
        assert page.requests() == []
