"""Pictures by OpenGL, drawn by MuJoCo's renderer. `context` says whether this machine can; `scene` draws."""
