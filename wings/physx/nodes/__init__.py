"""Nodes of PhysX's sensors (`isaacsim.sensors.physx`) and of the rays that they draw."""
