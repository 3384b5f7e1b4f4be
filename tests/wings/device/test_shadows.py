"""What lies in the shadow of what: as found on the processor, on a device too."""

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")

from graph.sim import App
from sensors.raycast.shadows import Shadows
from sensors.raycast.shared import cast_world
from tests.support.devices import on_each

PRIMS = {
    "/Ground": {"type": "Cube", "size": 1.0, "scale": [20, 20, 1], "translate": [0, 0, -0.5]},
    "/Ball": {"type": "Sphere", "radius": 0.5, "translate": [0, 0, 1.5], "rigid_body": True, "velocity": [1, 0, 0]},
    "/Post": {"type": "Cube", "size": 1.0, "scale": [0.2, 0.2, 2], "translate": [-2, 0, 1]},
}


def dark_on(device, light, far):
    """Points of a grid on the ground that a light does not reach, after half a second; (m,) bool."""
    axis = np.linspace(-4, 4, 81) + 0.013  # beside the edges of shadows
    x, y = (one.ravel() for one in np.meshgrid(axis, axis))
    points = np.stack([x, y, np.full(len(x), 1e-3)]).astype(np.float32)
    ways = (light[:, None] if far else light[:, None] - points).astype(np.float32)
    with App(physics_hz=60, loop_hz=60, device=device) as app:
        app.add_prims({**PRIMS, "/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}})
        app.play()
        app.update(steps=30)
        shadows = Shadows(cast_world(app.world), frozenset())
        return x, y, shadows.blocked(np.zeros(3), points, ways, np.arange(len(x)), None, far=far)


@on_each
@pytest.mark.parametrize(("light", "far"), [((0.0, 0.0, 1.0), True), ((0.0, 0.0, 3.0), False)], ids=["sun", "lamp"])
def test_points_are_dark_where_the_ball_and_the_post_stand_before_the_light(device, light, far):
    """A sun above: below the ball, which is at 0.5 m by then, within its radius; the post's own foot."""
    x, y, dark = dark_on(device, np.array(light), far)
    assert np.array_equal(dark, dark_on("cpu", np.array(light), far)[2])
    if far:
        below = np.hypot(x - 0.5, y) < 0.5 - 1e-6
        foot = (abs(x + 2) < 0.1 + 1e-6) & (abs(y) < 0.1 + 1e-6)
        near = abs(np.hypot(x - 0.5, y) - 0.5) < 0.02  # the ball's triangles lie a little inside it
        assert np.array_equal(dark[~near], (below | foot)[~near])
    assert 30 < dark.sum() < len(dark) / 2
