"""`isaacsim`: SimulationApp, which makes the App of a script."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from typing import Any

from graph.base.errors import RunError
from graph.isaac.outcomes import inert
from graph.isaac.run import RUN, ScriptEnd
from graph.isaac.session import begin, warn

__all__ = ["AppFramework", "SimulationApp"]

DEFAULTS: dict[str, Any] = {
    "headless": True,
    "hide_ui": None,
    "active_gpu": None,
    "physics_gpu": 0,
    "multi_gpu": True,
    "max_gpu_count": None,
    "sync_loads": True,
    "width": 1280,
    "height": 720,
    "window_width": 1440,
    "window_height": 900,
    "display_options": 3094,
    "subdiv_refinement_level": 0,
    "renderer": "RealTimePathTracing",
    "anti_aliasing": 3,
    "samples_per_pixel_per_frame": 64,
    "denoiser": True,
    "max_bounces": 3,
    "max_specular_transmission_bounces": 3,
    "max_volume_bounces": 15,
    "open_usd": None,
    "fast_shutdown": True,
    "profiler_backend": [],
    "create_new_stage": True,
    "extra_args": [],
    "enable_crashreporter": True,
    "limit_cpu_threads": 32,
    "disable_viewport_updates": False,
    "minimal_shading_mode": 0,
    "shutdown_watchdog_timeout": 120.0,
    "experience": "",
}


class SimulationApp:
    DEFAULT_LAUNCHER_CONFIG = DEFAULTS
    _instance: SimulationApp | None = None

    def __init__(self, launch_config: Mapping[str, Any] | None = None, experience: str = "") -> None:
        run = RUN.get()
        if run is None:
            raise RunError("SimulationApp runs in a script that `graph exec SCRIPT.py` runs; here, use graph.sim.App")
        if run.from_editor and run.app is not None:
            raise RunError("this script runs in an application that is there already; a process runs one")
        self.config: dict[str, Any] = {**DEFAULTS, **(launch_config or {})}
        self._run = run
        self._exiting = False
        settings = settings_in(self.config["extra_args"] or [])
        if self.config.get("enable_motion_bvh"):
            base = "/renderer/raytracingMotion"
            settings |= {
                f"{base}/enabled": True,
                f"{base}/enableHydraEngineMasking": True,
                f"{base}/enabledForHydraEngines": "0,1,2,3,4",
            }
        file = str(experience or self.config["experience"] or "")
        begin(
            run,
            stage=_local(self.config["open_usd"]) if self.config["open_usd"] else None,
            settings=settings,
            experience=experience_of(file),
        )
        if not self.config["headless"]:
            warn("isaac-headless", "SimulationApp", "there is no window here: it runs headless")
        SimulationApp._instance = self

    @property
    def app(self) -> Any:
        from .kit_app import get_app

        return get_app()

    @property
    def context(self) -> Any:
        from .usd import get_context

        return get_context()

    def update(self) -> None:
        self.app.update()

    def is_running(self) -> bool:
        return not (self._exiting or self._run.over())

    def is_exiting(self) -> bool:
        return self._exiting

    def close(self, wait_for_replicator: bool = True, skip_cleanup: bool = False, exit_code: int = 0) -> None:
        if self._exiting:
            return
        self._exiting = True
        self._run.code = exit_code
        self._run.close()
        if self.config["fast_shutdown"]:
            raise ScriptEnd(exit_code)

    def set_setting(self, setting: str, value: Any) -> None:
        from .carb_settings import get_settings

        get_settings().set(setting, value)

    @inert("isaacsim")
    def reset_render_settings(self) -> None:
        return None

    def run_coroutine(self, coroutine: Any, run_until_complete: bool = True) -> Any:
        from graph.isaac.session import kit

        if run_until_complete:
            return kit().finish(coroutine)
        from asyncio import ensure_future

        return ensure_future(coroutine, loop=kit().loop)

    def __enter__(self) -> SimulationApp:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class AppFramework:
    def __init__(self, name: str = "kit", argv: list[str] | None = None) -> None:
        self._app = SimulationApp({"extra_args": argv or []})
        self.framework = None

    @property
    def app(self) -> Any:
        return self._app.app

    def update(self) -> None:
        self._app.update()

    def close(self) -> None:
        self._app.close()


def settings_in(arguments: list[str]) -> dict[str, Any]:
    """The settings among Kit's arguments, `--/path=value`."""
    from graph.sim.settings import parse_option

    return dict(parse_option(one) for one in arguments if str(one).startswith("--/") and "=" in one)


def experience_of(file: str) -> str:
    """The experience that a `.kit` file stands for."""
    name = os.path.basename(file)
    return next((one for one in ("zero_delay", "full") if one in name), "base")


def _local(address: str) -> str:
    from graph.isaac.assets import local_path

    return local_path(address) or sys.exit(f"{address} is not here")
