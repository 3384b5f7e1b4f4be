"""What sensors see of a surface: its material and optics, its object id, its semantic labels."""
