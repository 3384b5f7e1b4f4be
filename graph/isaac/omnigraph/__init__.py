"""`omni.graph.core` over `graph.isaac.og`: handles, types and the Controller with OmniGraph's arguments."""
