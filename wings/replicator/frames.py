"""Events of new frames, and what tells frames apart."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.base.exact import nanoseconds
from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct

EXEC = Attribute("execution", "a new frame")
RESULTS_IN = Attribute("uint64", "handle of a render product, from SdOnNewRenderProductFrame", default=0)
CUDA_STREAM = Attribute("uint64", "always 0: frames are in host memory")


@dataclass(slots=True)
class _Handed:
    """The frames of each product at the last activation, and the handles on its outputs."""

    frames: dict[str, int] = field(default_factory=dict)
    handles: list[int] = field(default_factory=list)


def _drop(db: Database) -> None:
    from sensors.handles import forget

    while db.memory.handles:
        forget(db.memory.handles.pop())


@node_type(
    "omni.syntheticdata.SdOnNewFrame",
    version=1,
    event=True,
    phase="post_render_graphs",
    outputs={
        "cudaStream": CUDA_STREAM,
        "exec": Attribute("execution", "fires once for all frames that came together"),
        "referenceTimeDenominator": Attribute("uint64", "denominator of the frames' time", unit="1"),
        "referenceTimeNumerator": Attribute("int64", "numerator of the frames' time [s]", unit="s"),
        "renderProductDataPtrs": Attribute("uint64[]", "handles of the products, in the order of their paths"),
        "renderProductPaths": Attribute("token[]", "paths of the products with a new frame"),
    },
    memory=_Handed,
    release=_drop,
)
def on_new_frame(db: Database) -> bool:
    """Fire when render products have new frames: in the same update in a post_render or on_demand graph, else in the
    next one.
    """
    from sensors.handles import handle

    memory, outputs = db.memory, db.outputs
    products = db.app.rendering.products.values()
    new = [one for one in products if one.frame is not None and memory.frames.get(one.path) != one.frames]
    if not new:
        return False
    _drop(db)
    memory.frames = {one.path: one.frames for one in products}
    memory.handles = [handle(one) for one in new]
    newest = max(one.frame.reference for one in new)
    outputs.referenceTimeNumerator, outputs.referenceTimeDenominator = newest.numerator, newest.denominator
    outputs.renderProductDataPtrs, outputs.renderProductPaths = list(memory.handles), [one.path for one in new]
    db.fire("exec")
    return True


@node_type(
    "omni.syntheticdata.SdOnNewRenderProductFrame",
    version=1,
    needs=(("renderProductPath",),),
    inputs={
        "exec": Attribute("execution", "new frames; in a post_render graph those of the product, if not connected"),
        "renderProductDataPtrs": Attribute("uint64[]", "handles of the products with a new frame", default=[]),
        "renderProductPath": Attribute("token", "path of the product to wait for", default="", role="product"),
        "renderProductPaths": Attribute("token[]", "paths of the products with a new frame", default=[]),
    },
    outputs={
        "cudaStream": CUDA_STREAM,
        "exec": Attribute("execution", "fires for each new frame of the product"),
        "renderProductPath": Attribute("token", "path of the product", role="product"),
        "renderResults": Attribute("uint64", "handle of the product"),
    },
    memory=_Handed,
    release=_drop,
)
def on_new_render_product_frame(db: Database) -> bool:
    """Pass on the new frames of one render product."""
    from sensors.handles import handle

    inputs, outputs = db.inputs, db.outputs
    path, paths = inputs.renderProductPath, list(inputs.renderProductPaths)
    if db.connected("renderProductPaths") and path not in paths:
        return False
    product = db.app.rendering.products.get(path)
    if product is None:
        db.lack(f"there is no render product {path or '(empty path)'}; connect renderProductPath to one")
    _drop(db)
    db.memory.handles = [handle(product)]
    outputs.renderResults, outputs.renderProductPath = db.memory.handles[0], path
    db.fire("exec")
    return True


NO_NUMBER, NUMBER, CONSTANT = "NoFrameNumber", "FrameNumber", "ConstantFramerateFrameNumber"


@node_type(
    "omni.syntheticdata.SdFrameIdentifier",
    version=1,
    inputs={"exec": EXEC, "renderResults": RESULTS_IN},
    outputs={
        "durationDenominator": Attribute("uint64", "denominator of the time between frames", default=0, unit="1"),
        "durationNumerator": Attribute("int64", "numerator of the time between frames [s]", default=0, unit="s"),
        "exec": Attribute("execution", "follows every frame"),
        "externalTimeOfSimNs": Attribute("int64", "time of the frame", default=-1, unit="ns"),
        "frameNumber": Attribute("int64", "number of the product's frame, from 0", default=-1),
        "rationalTimeOfSimDenominator": Attribute("uint64", "denominator of the frame's time", default=0, unit="1"),
        "rationalTimeOfSimNumerator": Attribute("int64", "numerator of the frame's time [s]", default=0, unit="s"),
        "sampleTimeOffsetInSimFrames": Attribute("uint64", "always 0", default=0, unit="frames"),
        "type": Attribute(
            "token",
            f"{CONSTANT} for a sensor with a rate, {NUMBER} for one that renders in every update",
            default=NO_NUMBER,
            allowed_tokens=(NO_NUMBER, NUMBER, CONSTANT),
        ),
    },
)
def frame_identifier(db: Database) -> bool:
    """Give number and time of a product's newest frame."""
    product, outputs = product_of_handle(db), db.outputs
    frame = None if product is None else product.frame
    if product is None or frame is None:
        return False
    rate = product.sensor.schedule.rate
    outputs.type = CONSTANT if rate else NUMBER
    outputs.durationNumerator, outputs.durationDenominator = (rate.denominator, rate.numerator) if rate else (0, 0)
    time = frame.reference
    outputs.externalTimeOfSimNs, outputs.frameNumber = nanoseconds(time), frame.frame_id
    outputs.rationalTimeOfSimNumerator, outputs.rationalTimeOfSimDenominator = time.numerator, time.denominator
    db.fire("exec")
    return True


def product_of_handle(db: Database) -> RenderProduct | None:
    """The render product of renderResults; None before there is one. Fails the node for a handle of something else."""
    from graph.sim.renderer.products import RenderProduct
    from sensors.handles import resolve

    number = db.inputs.renderResults
    found: Any = resolve(number)
    if not isinstance(found, RenderProduct):
        if number:
            db.fail("input renderResults is not a handle of a render product; connect SdOnNewRenderProductFrame")
        db.warn("render-product-missing", "input renderResults is 0; connect it to SdOnNewRenderProductFrame")
        return None
    return found


@node_type(
    "omni.graph.nodes.GpuInteropRenderProductEntry",
    version=2,
    event=True,
    outputs={
        "exec": Attribute("execution", "fires where its graph is evaluated for a new frame"),
        "gpu": Attribute("uint64", "always 0: there are no addresses here"),
        "hydraTime": Attribute("double", "renderer time of the frame", unit="s"),
        "rp": Attribute("uint64", "always 0: render products are named by path"),
        "simTime": Attribute("double", "simulation time of the frame", unit="s"),
    },
)
def gpu_interop_render_product_entry(db: Database) -> bool:
    """Start the render pipeline of a saved scene; without a new frame it does nothing."""
    app = db.context.app
    if app is None or not app.rendering.new_frames:
        return False
    newest = max(product.frame.reference for product in app.rendering.new_frames)
    db.outputs.hydraTime = float(newest)
    db.outputs.simTime = app.simulation.of_frame(newest, "simulation")
    db.fire("exec")
    return True
