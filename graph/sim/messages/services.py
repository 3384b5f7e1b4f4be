"""Services: requests and responses between clients and servers of one App."""

from __future__ import annotations

from collections import deque
from typing import Any

from graph.base.errors import RunError
from graph.base.records import dataclass, field


@dataclass(slots=True)
class Call:
    """One request, and its response when it has been answered; `lost` if the server closed before."""

    request: Any
    response: Any = None
    lost: bool = False


@dataclass(slots=True)
class Server:
    """The one server of a service: requests wait until `take` returns them; `answer` answers the oldest taken one."""

    name: str
    type_name: str
    owner: str
    handle: int
    waiting: deque[Call] = field(default_factory=deque)
    open: deque[Call] = field(default_factory=deque)

    def take(self) -> Any:
        """The oldest waiting request, which is to be answered, or None."""
        if not self.waiting:
            return None
        call = self.waiting.popleft()
        self.open.append(call)
        return call.request

    def answer(self, response: Any) -> bool:
        """Answers the oldest request that was taken and not answered; False if there is no such request."""
        if not self.open:
            return False
        self.open.popleft().response = response
        return True


class Services:
    """Servers by service name, and by the handle that server nodes pass on."""

    def __init__(self) -> None:
        self._servers: dict[str, Server] = {}
        self._handles: dict[int, Server] = {}
        self._next = 1

    def serve(self, name: str, type_name: str, owner: str = "") -> Server:
        """Opens a service (type "pkg/srv/Name"). Raises RunError if it has a server already."""
        other = self._servers.get(name)
        if other is not None:
            raise RunError(
                f"service {name} has a server already: {other.owner or other.type_name}; give this one another name"
            )
        server = self._servers[name] = self._handles[self._next] = Server(name, type_name, owner, self._next)
        self._next += 1
        return server

    def close(self, server: Server) -> None:
        """Closes a service; its open requests are lost. Closing twice is harmless."""
        for call in (*server.waiting, *server.open):
            call.lost = True
        server.waiting.clear()
        server.open.clear()
        if self._servers.get(server.name) is server:
            del self._servers[server.name]
        self._handles.pop(server.handle, None)

    def call(self, name: str, type_name: str, request: Any, caller: str = "") -> Call | None:
        """Sends a request; None if the service has no server. Raises RunError if the server is of another type."""
        server = self._servers.get(name)
        if server is None:
            return None
        if server.type_name != type_name:
            raise RunError(
                f"service {name}: {caller or 'the client'} calls {type_name}, but {server.owner or 'its server'} "
                f"serves {server.type_name}; make the two types agree"
            )
        call = Call(request)
        server.waiting.append(call)
        return call

    def server(self, handle: int) -> Server | None:
        """The server of a handle, or None."""
        return self._handles.get(handle)
