"""UCX nodes (`isaacsim.ucx.nodes`): the ROS 2 publishers and subscribers on topics named by port and tag."""
