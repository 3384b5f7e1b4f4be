"""`omni.kit.app`: the application."""

from __future__ import annotations

import os
from typing import Any

from graph.isaac.events import EventStream
from graph.isaac.names import names_of
from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.run import RUN
from graph.isaac.session import app, kit

__all__ = [
    "GLOBAL_EVENT_POST_UPDATE",
    "GLOBAL_EVENT_PRE_UPDATE",
    "GLOBAL_EVENT_UPDATE",
    "ExtensionManager",
    "IApp",
    "get_app",
    "get_app_interface",
]
GLOBAL_EVENT_PRE_UPDATE = "omni.kit.app:pre_update"
GLOBAL_EVENT_UPDATE = "omni.kit.app:update"
GLOBAL_EVENT_POST_UPDATE = "omni.kit.app:post_update"


def _extension_name(extension_id: str) -> str:
    """The name in an id such as `omni.ui-2.26.4`."""
    return str(extension_id).partition("-")[0]


def _exists(name: str) -> bool:
    """Whether something of an extension is here: a module, or a node type."""
    from graph.node.registry import DEFAULT

    ids = (one for listed in DEFAULT.library.types.values() for one in listed)
    return names_of(name).known or any(one.startswith(f"{name}.") for one in ids)


VERSION = "6.0.1"
"""Of all extensions."""


def _folder(name: str) -> str:
    return os.path.join(os.environ.get("ISAAC_PATH", os.sep), "exts", name)


class ExtensionManager:
    """Extensions whose modules or node types exist here are always enabled; others are said once each."""

    def __init__(self) -> None:
        self._asked: set[str] = set()
        self._disabled: set[str] = set()

    def set_extension_enabled_immediate(self, extension_id: str, enabled: bool) -> bool:
        name = _extension_name(extension_id)
        (self._disabled.discard if enabled else self._disabled.add)(name)
        if not enabled:
            tell_inert(f"extension {name}", "disabling an extension changes nothing here")
        elif not _exists(name):
            tell_inert(f"extension {name}", "nothing of it is here; enabling it changes nothing")
            self._asked.add(name)
        return True

    def set_extension_enabled(self, extension_id: str, enabled: bool) -> None:
        self.set_extension_enabled_immediate(extension_id, enabled)

    def is_extension_enabled(self, ext_name: str) -> bool:
        name = _extension_name(ext_name)
        return name not in self._disabled and (name in self._asked or _exists(name))

    def get_enabled_extension_id(self, ext_name: str) -> str | None:
        """Of an extension by its name, or by its id whose version may be cut short."""
        name = _extension_name(ext_name)
        asked = ext_name.removeprefix(name).removeprefix("-")
        return f"{name}-{VERSION}" if self.is_extension_enabled(name) and VERSION.startswith(asked) else None

    def get_extension_id_by_module(self, module: str) -> str | None:
        """The extension whose module this is; None for one that is not here."""
        name = _extension_name(module)
        return f"{name}-6.0.1" if _exists(name) else None

    def get_extension_dict(self, ext_id: str) -> dict[str, Any]:
        name = _extension_name(ext_id)
        return {"path": _folder(name), "package": {"id": ext_id, "name": name, "version": VERSION}}

    @inert("omni.kit.app")
    def get_extensions(self) -> tuple[dict[str, Any], ...]:
        return ()

    def get_extension_path(self, ext_id: str) -> str:
        """Where the extension's files would be; they are not here."""
        name = _extension_name(ext_id)
        tell_inert(f"the folder of extension {name}", "it is not here, nor what is below it; name files of your own")
        return _folder(name)

    def fetch_extension_versions(self, ext_name: str) -> list[dict[str, Any]]:
        return [{"id": f"{ext_name}-{VERSION}"}]

    def subscribe_to_extension_enable(self, *_: Any, **__: Any) -> None:
        tell_inert("omni.kit.app.ExtensionManager.subscribe_to_extension_enable")


class IApp:
    def update(self) -> None:
        kit().update()

    def is_running(self) -> bool:
        run = RUN.get()
        return run is None or not run.over()

    def post_quit(self, return_code: int = 0) -> None:
        run = RUN.get()
        if run is not None:
            run.code = return_code

    post_uncancellable_quit = post_quit

    def print_and_log(self, message: str) -> None:
        print(message)

    async def next_update_async(self) -> float:
        return await kit().next_update()

    pre_update_async = next_update_async
    post_update_async = next_update_async

    def get_extension_manager(self) -> ExtensionManager:
        return kit().singleton(ExtensionManager, ExtensionManager)

    def get_update_event_stream(self, runloop_name: str = "main") -> EventStream:
        return kit().update_stream

    def get_pre_update_event_stream(self, runloop_name: str = "main") -> EventStream:
        return kit().pre_update

    def get_post_update_event_stream(self, runloop_name: str = "main") -> EventStream:
        return kit().post_update

    def get_message_bus_event_stream(self, runloop_name: str = "main") -> EventStream:
        return kit().messages

    def get_shutdown_event_stream(self) -> EventStream:
        return kit().other_events

    get_startup_event_stream = get_log_event_stream = get_shutdown_event_stream

    def get_update_number(self) -> int:
        return app().update_index

    def get_time_since_start_s(self) -> float:
        return float(app().loop_time)

    def get_time_since_start_ms(self) -> float:
        return 1000 * self.get_time_since_start_s()

    def get_app_name(self) -> str:
        return "Isaac-Sim"

    def get_app_version(self) -> str:
        return "6.0.1"

    def get_kit_version(self) -> str:
        return "107.3"

    get_build_version = get_kit_version

    def is_app_ready(self) -> bool:
        return True

    @inert("omni.kit.app")
    def delay_app_ready(self, requester_name: str) -> None: ...

    @inert("omni.kit.app")
    def startup(self, *_: Any) -> None: ...

    def shutdown(self) -> int:
        run = RUN.get()
        if run is not None:
            run.close()
        return 0


_IAPP = IApp()


def get_app() -> IApp:
    return _IAPP


def get_app_interface() -> IApp:
    return _IAPP
