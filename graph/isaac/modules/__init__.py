"""The behaviour behind Isaac Sim's modules; `names.txt` says which module has the names of which file here.

A file's `__all__` are the names that scripts may import. Isaac Sim documents them; a function here maps to one of
TickGraph in a line or three.
"""
