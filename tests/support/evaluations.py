"""Evaluating graphs of the test library, update by update."""


def run(graph, context, times=1):
    """Evaluates a graph in so many updates."""
    for _ in range(times):
        context.advance()
        graph.evaluate(context)


def watch(graph):
    """A list that fills with the names of the graph's nodes as an observer sees them compute."""
    seen = []

    def wrap(node, compute):
        def observed(db):
            seen.append(node.name)
            return compute(db)

        return observed

    graph.observe(wrap)
    return seen
