"""Physics sensors (`isaacsim.sensors.physics`): what bodies and joints feel, straight from the engine."""
