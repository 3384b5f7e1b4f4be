"""Render products: they give a sensor prim its sensor, its schedule and its place in the App."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graph.sim.scene.prim_paths import prim_at

from .errors import SensorValueError
from .sensor_types import sensor_type, sensor_types

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.sensor import Sensor
    from graph.sim.renderer.view import WorldView

ROOT = "/Render/OmniverseKit/HydraTextures"
"""Parent path of products, in the stage's session layer."""


def render_product(
    app: App, prim_path: str, resolution: Sequence[int] = (1280, 720), name: str | None = None
) -> RenderProduct:
    """The render product of a sensor prim of an App; see `shared_product`."""
    return shared_product(app.world, prim_path, resolution, name)


def shared_product(
    scene: WorldView, prim_path: str, resolution: Sequence[int] = (1280, 720), name: str | None = None
) -> RenderProduct:
    """The render product of a sensor prim at a resolution (width, height); an equal one is reused.

    name: last part of the product's path; by default made from prim and resolution. A product made while playing exists
    from the external time at the start of the present update. Raises SensorValueError (a UserError) for prims that are
    not sensors, for sensors that this version cannot render, and for a resolution of anything but two whole numbers.
    """
    if not prim_path:
        raise SensorValueError("there is no prim (empty path) to render; give the path of a sensor")
    size = image_size(resolution, "(width, height)")
    for product in scene.rendering.products.values():
        if product.camera_path == prim_path and product.resolution == size:
            return product
    return place_product(scene, f"{ROOT}/{_free_name(scene, name or product_name(prim_path, size))}", prim_path, size)


def image_size(resolution: Sequence[Any], words: str) -> tuple[int, int]:
    """A size (width, height) as two ints, of any sign; words: its name in the error message.

    Raises SensorValueError for anything else.
    """
    try:
        numbers = [int(side) for side in resolution]
        if len(numbers) == 2 and numbers == [*resolution]:
            return numbers[0], numbers[1]
    except (TypeError, ValueError, OverflowError):
        pass
    raise SensorValueError(f"resolution {resolution!r} is not {words}: give two whole numbers")


def place_product(scene: WorldView, path: str, prim_path: str, resolution: tuple[int, int]) -> RenderProduct:
    """A new render product at a path; an existing one is replaced. Without a sensor ("") it renders nothing.

    Warns where a helper publishes what is replaced: its writers end with it.
    Raises SensorValueError as `render_product` does; then nothing has changed.
    """
    from graph.sim.renderer.products import RenderProduct

    product = RenderProduct(path, prim_path, resolution, _sensor(scene, prim_path, resolution))
    if (before := scene.rendering.products.get(path)) is not None:
        if before.writers:
            scene.warn(
                "render-product-replaced",
                path,
                "it has another sensor or size: a helper that publishes its frames goes on once it is triggered again; "
                "trigger it in every update",
            )
        scene.rendering.remove(path)
    _author(scene, path, prim_path, resolution)
    scene.rendering.add(product)
    if prim_path:
        _follow_prim(scene, product)
    return product


def _follow_prim(scene: WorldView, product: RenderProduct) -> None:
    """Makes the sensor read its prim again, at each play and, while playing, in the update after a change.

    Without the prim, or with an inactive one, the product renders nothing until it is there again.
    """

    def refresh() -> None:
        if product.scene is None:
            while ends:
                ends.pop()()
            return
        prim, was_lost = prim_at(scene.stage, product.camera_path), product.lost
        product.lost = not (prim and prim.IsActive())
        if product.lost:
            if not was_lost:
                scene.warn(
                    "sensor-removed", product.camera_path, "its prim is gone, so it gives no frames until it is back"
                )
        elif product.sensor.refresh() and product.enabled:
            product.enabled = False  # off and on: the scheduler then reads the new schedule
            product.enabled = True

    ends = [scene.on(event, refresh) for event in ("play", "sensors_edited")]


def product_name(prim_path: str, resolution: tuple[int, int], word: str = "rtx_sensor") -> str:
    """The word, _ and eight hexadecimal digits that depend on the prim and the resolution alone."""
    digest = hashlib.blake2b(f"{prim_path} {resolution}".encode(errors="surrogatepass"), digest_size=4)
    return f"{word}_{digest.hexdigest()}"


def remove_product(scene: WorldView, product: RenderProduct) -> None:
    """Removes a product and its prim."""
    from graph.sim.usd import Usd

    scene.rendering.remove(product.path)
    with Usd.EditContext(scene.stage, scene.stage.GetSessionLayer()):
        scene.stage.RemovePrim(product.path)


def sensor_problem(stage: Usd.Stage, prim_path: str) -> str | None:
    """Why a prim cannot be rendered, as one line, or None."""
    prim = prim_at(stage, prim_path)
    if not prim:
        return f"there is no prim {prim_path} to render; give the path of a sensor"
    name, known = str(prim.GetTypeName()), [one.prim_type for one in sensor_types().values() if not one.read_by]
    if name in known:
        return None
    if kind := sensor_type(name):
        return f"{prim_path}: a {name} is not rendered; {kind.read_by} reads it without a render product"
    return f"{prim_path}: a {name or 'typeless prim'} is not a sensor; give the path of an {' or '.join(known)}"


def _sensor(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> Sensor:
    if not prim_path:
        from .blank import Blank

        return Blank(scene)
    if problem := sensor_problem(scene.stage, prim_path):
        raise SensorValueError(problem)
    return sensor_types()[str(scene.stage.GetPrimAtPath(prim_path).GetTypeName())].runtime(scene, prim_path, resolution)


def _free_name(scene: WorldView, wanted: str) -> str:
    base = re.sub(r"\W", "_", wanted)
    name, number = base, 1
    while f"{ROOT}/{name}" in scene.rendering.products:
        name, number = f"{base}_{number:02}", number + 1
    return name


def _author(scene: WorldView, path: str, camera: str, size: tuple[int, int]) -> None:
    """Writes the product as a RenderProduct prim, in the session layer, because it is not part of the scene."""
    from graph.sim.usd import Gf, Usd, UsdRender

    with Usd.EditContext(scene.stage, scene.stage.GetSessionLayer()):
        prim = UsdRender.Product.Define(scene.stage, path)
        prim.CreateCameraRel().SetTargets([camera] if camera else [])
        prim.CreateResolutionAttr().Set(Gf.Vec2i(*size))
