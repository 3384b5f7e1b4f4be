"""The list of compiled forms: whole, readable, and what a warm-up compiles."""

import json
import os
import pkgutil
import re
import subprocess
import sys
from importlib import import_module

import numpy as np
import pytest

import sensors
from sensors.compiled.functions import Compiled
from sensors.compiled.kept import numba
from sensors.compiled.signatures import LIST, listed, text_of, type_of
from tests.sensors.compiled.listing import COMMAND
from tests.support.places import ROOT

WRITTEN = json.loads(LIST.read_text())


def loops():
    """The names of all compiled functions of the package."""
    for found in pkgutil.walk_packages(sensors.__path__, "sensors."):
        module = import_module(found.name)
        yield from (one.name for one in vars(module).values() if isinstance(one, Compiled))


def test_every_compiled_function_is_listed():
    assert set(loops()) == set(WRITTEN), f"run {COMMAND}"


def test_no_example_compiles_what_is_not_listed():
    """So a wheel's code serves them all. In a fresh process: other tests compile for types of their own."""
    code = "import json\nfrom tests.sensors.compiled.listing import used\nprint(json.dumps(used()))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    needed = json.loads(done.stdout)
    lacking = {name: [form for form in forms if form not in WRITTEN.get(name, [])] for name, forms in needed.items()}
    assert {name: forms for name, forms in lacking.items() if forms} == {}, f"run {COMMAND}"


@pytest.mark.parametrize("name", WRITTEN)
def test_a_type_is_the_one_that_its_text_says(name):
    for form in WRITTEN[name]:
        assert [text_of(type_of(text)) for text in form] == form


@pytest.mark.parametrize("name", sorted(set(re.findall(r'"(sensors\.[\w.]+)\[::1\]"', LIST.read_text()))))
def test_an_array_of_records_has_the_type_that_a_call_gives_it(name):
    """Aligned or packed, as the dtype is: code for the other kind is never found."""
    module, _, dtype = name.rpartition(".")
    records = np.empty(1, getattr(import_module(module), dtype))
    assert str(type_of(f"{name}[::1]")) == str(numba().typeof(records))


def test_what_is_compiled_ahead_is_what_a_call_asks_for(tmp_path):
    """A fresh process with a folder of its own: one warms up one loop, the next finds its code."""
    warm = "from sensors.compiled.signatures import LIST, function, type_of\n"
    warm += "import json\nname = 'sensors.camera.rays._face'\n"
    warm += "for form in json.loads(LIST.read_text())[name]: function(name).code.compile(tuple(map(type_of, form)))"
    call = "import numpy as np\nfrom sensors.camera.rays import _face\n"
    call += "_face(np.zeros((2, 3), np.float32), np.ones((3, 2), np.float32))\nprint(len(_face.kept.misses))"
    env = {**os.environ, "TICKGRAPH_CACHE": str(tmp_path), "PYTHONPATH": str(ROOT)}
    for code, said in ((warm, ""), (call, "0\n")):
        done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (0, said), done.stderr


def test_the_list_is_read_with_the_functions_that_it_names():
    assert [loop.name for loop, _ in listed()] == [name for name, forms in WRITTEN.items() for _ in forms]
