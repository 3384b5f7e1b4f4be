import pytest

from graph import ComputeError
from graph.base.errors import UserError
from graph.session.open import open_session
from graph.testing import run_node

CREATE = "IsaacCreateRenderProduct"


def create(app, updates=3, **inputs):
    inputs = {"cameraPrim": "/World/Lidar", **inputs}
    return run_node(CREATE, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_a_product_is_made_once_and_every_activation_goes_on(lidar, world):
    lidar()
    app = world()
    trace = create(app)
    assert trace.fired("execOut") == [0, 1, 2]
    assert list(app.rendering.products) == [trace.value("renderProductPath")]


def test_an_equal_product_is_used_again_and_another_size_gets_its_own(lidar, world):
    lidar()
    app = world()
    first, second, third = create(app), create(app), create(app, width=640)
    paths = [trace.value("renderProductPath") for trace in (first, second, third)]
    assert paths[0] == paths[1] != paths[2]
    assert len(app.rendering.products) == 2


def test_a_change_of_size_gives_another_product_in_place_of_the_first(lidar, world):
    lidar()
    app = world()
    trace = create(app, width=lambda update: 640 if update else 1280)
    paths = trace.values("renderProductPath")
    assert paths[0] != paths[1] == paths[2]
    assert list(app.rendering.products) == [paths[1]]


def test_a_disabled_node_does_nothing(lidar, world):
    lidar()
    app = world()
    assert create(app, enabled=False).fired("execOut") == []
    assert not app.rendering.products


def test_a_given_product_is_used(lidar, world):
    lidar()
    app = world()
    path = create(app).value("renderProductPath")
    trace = create(app, cameraPrim=[], renderProductPrim=path)
    assert trace.value("renderProductPath") == path


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"cameraPrim": []}, "input cameraPrim names 0 prims"),
        ({"cameraPrim": "/World/Gone"}, "there is no prim /World/Gone"),
        ({"cameraPrim": "/World/Ahead"}, "a Cube is not a sensor"),
        ({"renderProductPrim": "/Render/Gone"}, "there is no render product /Render/Gone"),
    ],
)
def test_what_cannot_be_rendered_is_reported(lidar, world, inputs, message):
    lidar()
    with pytest.raises(ComputeError, match=message):
        create(world(), **inputs)


def test_a_size_that_no_picture_has_is_refused_at_its_place_when_the_file_is_opened(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text(
        "tickgraph: 1\nscene: {prims: {/C: {type: Camera}}}\ngraphs:\n  /G:\n    nodes:\n"
        "      p: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /C, width: 0, height: 9}}\n"
    )
    with pytest.raises(UserError, match=r"g.yaml:6:\d+: /G/p.inputs:width: /C: an image of 0 x 9 has no pixels"):
        open_session(file).close()


def test_several_sensors_are_refused_at_their_place_when_the_file_is_opened(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text(
        "tickgraph: 1\nscene: {prims: {/C: {type: Camera}, /D: {type: Camera}}}\ngraphs:\n  /G:\n    nodes:\n"
        "      p: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: [/C, /D]}}\n"
    )
    with pytest.raises(
        UserError, match=r"g.yaml:6:\d+: /G/p.inputs:cameraPrim: names 2 prims; give it the path of one"
    ):
        open_session(file).close()
