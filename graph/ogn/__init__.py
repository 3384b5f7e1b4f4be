"""Node types declared by `.ogn` files, OmniGraph's JSON declarations, with a Python implementation beside each.

An installed package declares its `.ogn` files by an entry point:

    [project.entry-points."tickgraph.ogn"]
    "acme.nodes" = "acme_nodes"

Each `OgnThing.ogn` in that package is a node type; `OgnThing.py` beside it has the class `OgnThing` with a static
`compute(db)` (also `internal_state()` and `release(node)`), or just a function `compute`. A type name without a dot
gets the entry point's name as prefix.

`import omni.graph.core as og` at the top of such a module gives a stand-in with `ExecutionAttributeState` and the names
of `graph.isaac.og`; Kit's other modules are not available. `db.outputs.NAME_size = n` sets the length of an array
output.
"""

from .packages import register_package
from .reading import OgnNode, read_ogn

__all__ = ["OgnNode", "read_ogn", "register_package"]
