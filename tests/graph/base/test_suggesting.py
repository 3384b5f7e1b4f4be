"""What objects say about attributes that they do not have, and functions about callbacks that cannot be called."""

import copy
import pickle
from typing import ClassVar

import pytest

from graph import node_type
from graph.base.errors import UserError
from graph.base.suggesting import Suggesting
from graph.sim import App
from sensors import on_frame


class Robot(Suggesting):
    _instead: ClassVar = {"go": "robot.drive(speed)"}

    def __init__(self):
        self.positions = [1.0]

    @property
    def broken(self):
        return self.positions.missing


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("position", 'Robot has no "position"; did you mean "positions"?'),
        ("go", 'Robot has no "go"; use robot.drive(speed)'),
        ("xyzzy", 'Robot has no "xyzzy"'),
    ],
)
def test_a_wrong_attribute_is_named_with_the_one_that_was_meant(name, said):
    with pytest.raises(AttributeError) as raised:
        getattr(Robot(), name)
    assert str(raised.value) == said
    assert raised.value.name == name


def test_an_object_that_suggests_is_still_asked_copied_and_pickled_as_any_other():
    robot = Robot()
    assert not hasattr(robot, "position")
    assert getattr(robot, "position", 5) == 5
    assert copy.deepcopy(robot).positions == copy.copy(robot).positions == [1.0]
    assert pickle.loads(pickle.dumps(robot)).positions == [1.0]
    with pytest.raises(AttributeError, match=r"__array__$"):
        _ = robot.__array__


def test_a_property_that_fails_says_its_own_error():
    with pytest.raises(AttributeError, match="'list' object has no attribute 'missing'"):
        _ = Robot().broken


@pytest.fixture(scope="module")
def app():
    with App() as app:
        yield app


@pytest.mark.parametrize(
    ("read", "meant"),
    [
        (lambda app: app.step, "use app.update(steps=n)"),
        (lambda app: app.run, "use app.update(steps=n)"),
        (lambda app: app.updat, 'did you mean "update"?'),
        (lambda app: app.simulation.tensors.position, 'did you mean "positions"?'),
        (lambda app: app.timeline.is_plaing, 'did you mean "is_playing"?'),
        (lambda app: app.settings.subscrib, 'did you mean "subscribe"?'),
        (lambda app: app.bus.subscrib, 'did you mean "subscribe"?'),
        (lambda app: app.rendering.product, 'did you mean "products"?'),
    ],
)
def test_the_parts_of_an_app_say_what_was_meant(app, read, meant):
    with pytest.raises(AttributeError) as raised:
        read(app)
    assert str(raised.value).endswith(meant)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda app: app.on("render", {}), "app.on(phase, callback) takes a function to call, but a dict is given"),
        (
            lambda app: on_frame("/P", "draw", app=app),  # type: ignore[arg-type]
            "on_frame(product, callback) takes a function to call",
        ),
        (lambda app: app.settings.subscribe("/a", []), "settings.subscribe(path, callback) takes a function to call"),
        (
            lambda app: node_type("a.B")({}),  # type: ignore[type-var]  # as a user may
            "@node_type('a.B') takes a function to call, but a dict is given",
        ),
        (lambda app: app.timeline.on_tick(5), "timeline.on_tick(callback) takes a function to call, but an int"),
        (lambda app: app.update_app(callback={}), "update_app(callback=...) takes a function to call, but a dict"),
        (lambda app: app.bus.subscribe(print), "bus.subscribe takes a sink (advertise, write, close)"),
    ],
)
def test_what_cannot_be_called_is_refused_at_once_in_one_line(app, call, said):
    with pytest.raises(TypeError) as raised:
        call(app)
    assert isinstance(raised.value, UserError)
    assert str(raised.value).startswith(said)
    assert "\n" not in str(raised.value)


def test_an_app_says_in_one_line_what_it_is_and_shows_its_parts_in_a_notebook(app):
    assert repr(app) == ("<App not playing at 0.000 s: loop 60 Hz, physics 60 Hz, 0 graphs, 0 render products>")
    assert app._repr_html_().startswith("<table><caption>&lt;App not playing")
