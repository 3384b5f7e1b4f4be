"""Running graphs that can be changed: what they say now, and the edits that are made to them."""
