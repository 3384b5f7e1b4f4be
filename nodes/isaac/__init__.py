"""World nodes (`isaacsim.core.nodes`): clocks, gates, render products, poses, odometry, articulations."""
