"""Isaac Sim's managers under their own names, and the ways to drive an App."""
