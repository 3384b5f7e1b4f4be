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

ROOT = "/Render/OmniverseKit/HydraTextures"
"""Parent path of products, in the stage's session layer."""


def render_product(
    app: App, prim_path: str, resolution: Sequence[int] = (1280, 720), name: str | None = None
) -> RenderProduct:
    """The render product of a sensor prim at a resolution (width, height); an equal one is reused.

    name: last part of the product's path; by default made from prim and resolution. A product made while playing exists
    from the external time at the start of the present update. Raises SensorValueError (a UserError) for prims that are
    not sensors, for sensors that this version cannot render, and for a resolution of anything but two whole numbers.
    """
    if not prim_path:
        raise SensorValueError("there is no prim (empty path) to render; give the path of a sensor")
    size = image_size(resolution, "(width, height)")
    for product in app.rendering.products.values():
        if product.camera_path == prim_path and product.resolution == size:
            return product
    return place_product(app, f"{ROOT}/{_free_name(app, name or product_name(prim_path, size))}", prim_path, size)


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


def place_product(app: App, path: str, prim_path: str, resolution: tuple[int, int]) -> RenderProduct:
    """A new render product at a path; an existing one is replaced. Without a sensor ("") it renders nothing.

    Warns where a helper publishes what is replaced: its writers end with it.
    Raises SensorValueError as `render_product` does; then nothing has changed.
    """
    from graph.sim.renderer.products import RenderProduct

    product = RenderProduct(path, prim_path, resolution, _sensor(app, prim_path, resolution))
    if (before := app.rendering.products.get(path)) is not None:
        if before.writers:
            app.warn(
                "render-product-replaced",
                path,
                "it has another sensor or size: a helper that publishes its frames goes on once it is triggered again; "
                "trigger it in every update",
            )
        app.rendering.remove(path)
    _author(app, path, prim_path, resolution)
    app.rendering.add(product)
    if prim_path:
        _follow_prim(app, product)
    return product


def _follow_prim(app: App, product: RenderProduct) -> None:
    """Makes the sensor read its prim again, at each play and, while playing, in the update after a change.

    Without the prim, or with an inactive one, the product renders nothing until it is there again.
    """

    def refresh() -> None:
        if app.rendering.products.get(product.path) is not product:
            while ends:
                ends.pop()()
            return
        prim, was_lost = prim_at(app.stage, product.camera_path), product.lost
        product.lost = not (prim and prim.IsActive())
        if product.lost:
            if not was_lost:
                app.warn(
                    "sensor-removed", product.camera_path, "its prim is gone, so it gives no frames until it is back"
                )
        elif product.sensor.refresh() and product.enabled:
            product.enabled = False  # off and on: the scheduler then reads the new schedule
            product.enabled = True

    ends = [app.on(event, refresh) for event in ("play", "sensors_edited")]


def product_name(prim_path: str, resolution: tuple[int, int], word: str = "rtx_sensor") -> str:
    """The word, _ and eight hexadecimal digits that depend on the prim and the resolution alone."""
    digest = hashlib.blake2b(f"{prim_path} {resolution}".encode(errors="surrogatepass"), digest_size=4)
    return f"{word}_{digest.hexdigest()}"


def remove_product(app: App, product: RenderProduct) -> None:
    """Removes a product and its prim."""
    from graph.sim.usd import Usd

    app.rendering.remove(product.path)
    with Usd.EditContext(app.stage, app.stage.GetSessionLayer()):
        app.stage.RemovePrim(product.path)


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


def _sensor(app: App, prim_path: str, resolution: tuple[int, int]) -> Sensor:
    if not prim_path:
        from .blank import Blank

        return Blank(app)
    if problem := sensor_problem(app.stage, prim_path):
        raise SensorValueError(problem)
    return sensor_types()[str(app.stage.GetPrimAtPath(prim_path).GetTypeName())].runtime(app, prim_path, resolution)


def _free_name(app: App, wanted: str) -> str:
    base = re.sub(r"\W", "_", wanted)
    name, number = base, 1
    while f"{ROOT}/{name}" in app.rendering.products:
        name, number = f"{base}_{number:02}", number + 1
    return name


def _author(app: App, path: str, camera: str, size: tuple[int, int]) -> None:
    """Writes the product as a RenderProduct prim, in the session layer, because it is not part of the scene."""
    from graph.sim.usd import Gf, Usd, UsdRender

    with Usd.EditContext(app.stage, app.stage.GetSessionLayer()):
        prim = UsdRender.Product.Define(app.stage, path)
        prim.CreateCameraRel().SetTargets([camera] if camera else [])
        prim.CreateResolutionAttr().Set(Gf.Vec2i(*size))
