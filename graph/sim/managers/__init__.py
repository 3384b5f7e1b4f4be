"""Isaac Sim's managers by their own names, and the ways to drive an App."""
