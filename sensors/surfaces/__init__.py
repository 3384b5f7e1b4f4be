"""Surface properties that sensors see: material and optics, object id, semantic labels."""
