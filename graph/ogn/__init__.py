"""Node types declared by `.ogn` files, OmniGraph's JSON declarations, with a Python implementation beside each.

An installed package tells of its `.ogn` files by an entry point:

    [project.entry-points."tickgraph.ogn"]
    "acme.nodes" = "acme_nodes"

Each `OgnThing.ogn` in that package is a node type; `OgnThing.py` beside it has the class `OgnThing` with a static
`compute(db)` (also `internal_state()` and `release(node)`), or just a function `compute`. The entry point's name goes
before type names without a dot.

`import omni.graph.core as og` at the top of such a module gives a stand-in with `ExecutionAttributeState` and what
`graph.controller` has; of Kit's other modules there is none. `db.outputs.NAME_size = n` makes room in an array output.
"""

from .packages import register_package
from .reading import OgnNode, read_ogn

__all__ = ["OgnNode", "read_ogn", "register_package"]
