"""The radar's images in mirrors that move: how fast the ways from them grow, against differences of their lengths."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sensors.radar.images import Images, Twists

STEP = 1e-5


def turned(vector, rate, time):
    """Turned for a time at a rate about its axis, by Rodrigues' formula."""
    angle = np.linalg.norm(rate) * time
    axis = rate / max(np.linalg.norm(rate), 1e-12)
    across = np.cross(axis, vector)
    return vector + np.sin(angle) * across + (1 - np.cos(angle)) * np.cross(axis, across)


def mirrored(point, normal, height):
    return point + 2 * (height - normal @ point) * normal


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_way_over_two_mirrors_grows_as_its_image_and_its_target_part(seed):
    """Two mirrors and the radar move and turn; the way to a point that flies is its distance from the second image.

    Its rate by central differences of 1e-5 s is good to 1e-6 m/s here.
    """
    random = np.random.default_rng(seed)
    normal = random.normal(size=(2, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = random.uniform(2, 5, 2)
    bodies, own = random.normal(size=(2, 6)), random.normal(size=6)
    target, speed = random.normal(size=3) * 10, random.normal(size=3)

    def length(time):
        image = own[:3] * time
        for n, h, twist in zip(normal, height, bodies, strict=True):
            now = turned(n, twist[3:], time)
            image = mirrored(image, now, now @ (turned(n * h, twist[3:], time) + twist[:3] * time))
        return np.linalg.norm(target + speed * time - image)

    twists, images = Twists.of(bodies, own), Images.none()
    for body in range(2):
        number = np.array([body])
        images = images.beyond(np.array([0]), normal[number], height[number], number, (twists, number))
    direction = target - images.place[0]
    direction /= np.linalg.norm(direction)
    seen = speed - own[:3] - np.cross(own[3:], target)
    expected = (length(STEP) - length(-STEP)) / (2 * STEP)
    assert abs((images.rate[0] + seen) @ direction - expected) < 1e-6
