"""Makes OpenGL available to MuJoCo's renderer, or says in one line what is missing."""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from functools import cache
from types import ModuleType

from graph.base.errors import UserError
from graph.base.extras import install_command

CHOICE = "MUJOCO_GL"
"""The environment variable by which MuJoCo's renderer chooses: egl, osmesa or glfw."""
RAYS = "or leave camera.backend at rays"


@cache
def require() -> None:
    """Makes a small OpenGL context and frees it.

    On Linux it is one of EGL, which needs no display, unless the environment variable MUJOCO_GL says otherwise. Raises
    UserError with the reason and what to do.
    """
    if importlib.util.find_spec("OpenGL") is None:
        raise UserError(f"camera.backend=gl needs PyOpenGL. Run: {install_command('gl')} ({RAYS})")
    try:
        context = _contexts().GLContext(16, 16)
        context.make_current()
        context.free()
    except Exception as error:  # a driver fails in ways of its own
        way, reason = os.environ.get(CHOICE, "a window"), " ".join(str(error).split()) or type(error).__name__
        install = "Without a graphics card run: apt-get install -y libegl1 libgl1-mesa-dri"
        remedy = install if way in ("egl", "a window") else f"Unset the environment variable {CHOICE}"
        raise UserError(f"camera.backend=gl: no OpenGL by {way} here ({reason}). {remedy} ({RAYS})") from error


def _contexts() -> ModuleType:
    """MuJoCo's module that holds the class of contexts, as chosen now: it chooses when it is first imported."""
    if sys.platform.startswith("linux"):
        os.environ.setdefault(CHOICE, "egl")
    from graph.sim.physics.mujoco.library import mujoco

    return importlib.reload(mujoco.rendering.classic.gl_context)
