"""Action-graph nodes (`omni.graph.action`): events, flow control, waiting, loops, log output."""
