"""The one module that imports MuJoCo; it also keeps MuJoCo's own warnings off the terminal and out of log files.

What a warning means for a run is read from the counters of `MjData` (see `engine`).
"""

from __future__ import annotations

import mujoco  # noqa: TID253

if mujoco.get_mju_user_warning() is None:
    mujoco.set_mju_user_warning(lambda text: None)

__all__ = ["mujoco"]
