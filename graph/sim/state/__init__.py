"""The state of the playing world: Fabric and tensors."""
