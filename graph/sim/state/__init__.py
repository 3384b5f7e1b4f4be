"""Where everything is while the world plays: Fabric, tensors, articulations."""
