"""Writers as classes with their own annotators, as in Replicator."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graph.sim import settings as keys
from sensors.annotators.annotator import Annotator
from sensors.annotators.registry import find_annotator

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct
    from sensors.frame import Frame


class AnnotatedWriter:
    """Base of a writer: set `annotators` in `__init__`; `write` receives their data of each new frame.

        class Count(rep.Writer):
            def __init__(self):
                self.annotators = [rep.annotators.get("GenericModelOutput")]

            def write(self, data):
                print(parse_generic_model_output_data(data["GenericModelOutput"]).numElements)

        rep.WriterRegistry.register(Count)
        rep.writers.get("Count").attach(product)

    annotators: annotators, or their names. data_structure: "annotator" gives `write` {annotator: data}, "renderProduct"
    {"renderProducts": {name of the product: {annotator: data}}}. Arguments of `initialize` are those of `__init__`.
    """

    annotators: Sequence[Annotator | str] = ()
    data_structure = "annotator"
    prepare: Callable[[list[Annotator]], list[Annotator]] | None = None
    """Gives the annotators to attach, from those of the writer."""
    _attached: Sequence[Annotator] = ()
    _product: RenderProduct | None = None

    def write(self, data: Mapping[str, Any]) -> None:
        """Receives the annotators' data of a new frame."""
        raise NotImplementedError(f"{type(self).__name__} has no method write(data)")

    def attach_to(self, product: RenderProduct) -> None:
        """Attaches the annotators to a product.

        Raises SensorValueError if one cannot read it; then none is attached.
        """
        self._product, self._attached = product, []
        try:
            made = [Annotator(find_annotator(one)) if isinstance(one, str) else one for one in self.annotators]
            for annotator in self.prepare(made) if self.prepare else made:
                self._attached = [*self._attached, annotator.attach(product)]
        except BaseException:
            self.release()
            raise

    def release(self) -> None:
        """Detaches the annotators."""
        for annotator in self._attached:
            annotator.detach()
        self._attached = ()

    def __call__(self, frame: Frame) -> None:
        """Receives a new frame; while captureOnPlay is off, only those that the orchestrator's steps render."""
        product = self._product
        assert product is not None
        if not product.stepped and product.scene is not None and not product.scene.settings.get(keys.CAPTURE_ON_PLAY):
            return
        data = {annotator.name: annotator.get_data() for annotator in self._attached}
        if self.data_structure == "renderProduct":
            self.write({"renderProducts": {product.path.rpartition("/")[2]: data}})
        else:
            self.write(data)
