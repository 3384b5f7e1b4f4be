"""Physics sensors (`isaacsim.sensors.physics`): readings of bodies and joints, directly from the physics engine."""
