"""The one module that imports MuJoCo; it also keeps MuJoCo's own warnings off the terminal and out of log files.

What a warning means for a run is read from the counters of `MjData` (see `engine`).
"""

from __future__ import annotations

import sys

import mujoco  # noqa: TID253

if mujoco.get_mju_user_warning() is None:
    mujoco.set_mju_user_warning(lambda text: None)

# Without OpenGL, MuJoCo keeps the error of its import, whose traceback would keep the first App of the process alive.
_kept = getattr(sys.modules.get("mujoco.rendering.classic.gl_context"), "_import_error", None)
while isinstance(_kept, BaseException):
    _kept.__traceback__, _kept = None, _kept.__cause__ or _kept.__context__

__all__ = ["mujoco"]
