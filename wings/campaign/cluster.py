"""Runs on the workers of a Dask cluster: `--cluster ADDRESS`.

What travels is data: command lines, hashes of files, and with `upload` the files and the results. The only function
that is called there is `execute` of this module, by its name, so scheduler and workers need nothing but tickgraph.
Each thread of a worker has a server of its own that forks a process for each run, as on one machine.
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from pathlib import Path
from typing import Any

from graph.base.errors import RunError, UserError
from graph.base.inputs import digest, opened
from graph.base.limits import check
from graph.base.outputs import make_folder, write

from .launcher import AGAIN, LOST, Ended, Launcher, Order

SHARED, UPLOAD = "shared", "upload"
NAMING = ("--nodes", "--play", "--allow")
"""Options of `graph run` that name files or folders."""
AHEAD = 2
"""Runs given to a thread of the cluster at a time, so that none waits for its next one."""
RECONNECT_S, CONNECT_S = 300.0, 10.0
"""How long a scheduler that is gone is waited for, and each attempt to reach it [s]."""
LOOK_S, COUNT_S = 0.2, 5.0

Payload = dict[str, Any]
Contents = dict[str, bytes]

_held = threading.local()


# -- on a worker -------------------------------------------------------------------------------------------------------


def execute(payload: Payload, contents: Contents | None = None) -> Payload:
    """Makes a run on a worker and returns how it ended; `missing` if the worker does not have its files.

    contents: the files, by name, for a worker that asked for them.
    """
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()
    worker.log_event(str(key), "started")
    if payload["transfer"] == UPLOAD:
        place = _uploaded(payload["files"], contents)
        if place is None:
            return {"missing": True, "worker": worker.address}
    else:
        place = payload["place"]
        if wrong := _not_shared(payload):
            return {"refused": f"worker {worker.address}: {wrong}"}
    order = Order(**payload["order"])
    with tempfile.TemporaryDirectory(prefix="tickgraph-run-") as scratch:
        if payload["transfer"] == UPLOAD:
            order = Order(**{**payload["order"], "folder": scratch})
        ended = _run(order, payload, place, lambda: _is_cancelled(worker, key))
        answer: Payload = {"ended": ended, "worker": worker.address}
        if payload["transfer"] == UPLOAD:
            answer["results"] = _contents(Path(scratch))
    return answer


def _run(order: Order, payload: Payload, place: str, cancelled: Callable[[], bool]) -> Payload:
    held = (place, str(payload["rehearse"]))
    if getattr(_held, "key", None) != held:
        if launcher := getattr(_held, "launcher", None):
            launcher.close()
        _held.launcher = Launcher(payload["rehearse"], play=True, place=place)
        _held.key = held
    launcher = _held.launcher
    launcher.start(order)
    while True:
        for ended in launcher.wait(LOOK_S):
            if ended.number == order.number:
                return {name: getattr(ended, name) for name in Ended.__slots__}
        if cancelled():
            launcher.stop(order.number)


def _is_cancelled(worker: Any, key: str) -> bool:
    task = worker.state.tasks.get(key)
    return task is None or task.state == "cancelled"


def _not_shared(payload: Payload) -> str:
    """What a worker does not share with the campaign; "" if it sees its folder and the same files."""
    if not Path(payload["order"]["folder"]).is_dir():
        return "it does not see the folder of --out; give --transfer upload"
    for file, known in payload["files"].items():
        try:
            same = _known_digest(str(Path(payload["place"]) / file)) == known
        except OSError:
            return f"it does not see {file}; give --transfer upload"
        if not same:
            return f"its {file} is another file; give --transfer upload"
    return ""


_digests: dict[tuple[str, int, int], str] = {}


def _known_digest(file: str) -> str:
    found = os.stat(file)
    key = (file, found.st_mtime_ns, found.st_size)
    if key not in _digests:
        _digests[key] = digest(file)
    return _digests[key]


_lock = threading.Lock()
_places: dict[str, tempfile.TemporaryDirectory[str]] = {}


def _uploaded(files: Mapping[str, str], contents: Contents | None) -> str | None:
    """The folder of uploaded files, each with its hash; None if this worker does not have them."""
    from hashlib import sha256

    whole = sha256(repr(sorted(files.items())).encode()).hexdigest()
    with _lock:
        if whole in _places:
            return _places[whole].name
        if contents is None:
            return None
        folder = tempfile.TemporaryDirectory(prefix="tickgraph-files-")
        for name, known in files.items():
            data = contents[name]
            if sha256(data).hexdigest() != known:
                raise RuntimeError(f"{name} was damaged on its way")
            *parents, last = Path(name).parts
            if Path(name).is_absolute() or ".." in parents:
                raise RuntimeError(f"{name} is not a place for an uploaded file")
            write(make_folder(Path(folder.name), *parents) / last, data)
        _places[whole] = folder
        return folder.name


def _contents(folder: Path) -> Contents:
    """Every file below a folder, by its name; links are left out."""
    found: Contents = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink():
            with opened(path) as stream:
                found[path.relative_to(folder).as_posix()] = stream.read()
    return found


# -- at the campaign ---------------------------------------------------------------------------------------------------


class Upload:
    """The files that travel: the folders in which the graph files may read, and single files, under numbers."""

    def __init__(self, folders: Sequence[Path], files: Sequence[Path], leave_out: Path) -> None:
        """Reads them. Raises UserError for a file that cannot be read, OverLimit if they are too large."""
        self.contents: Contents = {}
        self._names: dict[Path, str] = {}
        size = 0
        for number, root in enumerate(dict.fromkeys(one.resolve() for one in folders)):
            self._names[root] = str(number)
            for path in sorted(root.rglob("*")):
                if path.is_file() and not path.is_symlink() and not path.is_relative_to(leave_out.resolve()):
                    size += path.stat().st_size
                    check("campaign.upload", size, f"{root}: its files are too large to upload")
                    self._add(f"{number}/{path.relative_to(root).as_posix()}", path)
        for number, path in enumerate(dict.fromkeys(one.resolve() for one in files)):
            self._names[path] = f"files/{number}/{path.name}"
            self._add(self._names[path], path)

    def _add(self, name: str, path: Path) -> None:
        try:
            with opened(path) as stream:
                self.contents[name] = stream.read()
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; it cannot be uploaded") from None

    def name_of(self, argument: str) -> str:
        """An argument that names an uploaded file or folder, as the worker finds it; others as they are."""
        path = Path(argument).resolve()
        for root in (path, *path.parents):
            if root in self._names:
                return (Path(self._names[root]) / path.relative_to(root)).as_posix()
        return argument


class Cluster:
    """Runs orders on a Dask cluster; a scheduler that is gone is waited for. Use with `with`.

    hashes: of the files that runs read, by name. upload: the files, where workers do not share them. Raises RunError if
    there is no scheduler.
    """

    def __init__(
        self, address: str, hashes: Mapping[str, str], rehearse: Sequence[Sequence[str]], upload: Upload | None = None
    ) -> None:
        self._address, self._upload = address, upload
        self._rehearse = [self._moved(arguments) for arguments in rehearse]
        self._hashes = dict(hashes)
        if upload is not None:
            from hashlib import sha256

            self._hashes = {name: sha256(data).hexdigest() for name, data in upload.contents.items()}
        self._futures: dict[int, Any] = {}
        self._orders: dict[int, Order] = {}
        self._threads, self._counted = 1, 0.0
        self._started = 0
        self._client = self._connected(time.monotonic() + CONNECT_S)

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *error: object) -> None:
        self._disconnect()

    def slots(self, jobs: int) -> int:
        """As many runs as the user asks for; 0: some for each thread that the cluster has at the moment."""
        if jobs:
            return jobs
        now = time.monotonic()
        if now - self._counted > COUNT_S:
            self._counted = now
            with suppress(Exception):  # a scheduler that is gone is found by `wait`
                workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
                self._threads = sum(one["nthreads"] for one in workers)
        return max(1, AHEAD * self._threads)

    def start(self, order: Order) -> None:
        """Gives a run to the cluster."""
        self._orders[order.number] = order
        self._submit(order.number)

    def stop(self, number: int) -> None:
        """Ends a run."""
        if future := self._futures.pop(number, None):
            with suppress(Exception):
                future.cancel()

    def wait(self, seconds: float) -> list[Ended]:
        """The runs that have ended since the last call; waits for the first at most `seconds`."""
        from distributed import wait

        if not self._futures:
            time.sleep(seconds)
            return []
        try:
            wait([*self._futures.values()], timeout=seconds, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return [] if self._client.status == "running" else self._again()
        except (OSError, RuntimeError, CancelledError):  # the cluster has forgotten the runs
            return self._again()
        found: list[Ended] = []
        for number, future in [*self._futures.items()]:
            if future.status in ("cancelled", "lost"):
                return [*found, *self._again()]
            if future.done() and (ended := self._ended(number, future)):
                found.append(ended)
        return found

    def _ended(self, number: int, future: Any) -> Ended | None:
        try:
            answer = future.result(timeout=CONNECT_S)
            attempts = max(1, len(self._client.get_events(future.key)))
        except TimeoutError:
            return None
        except Exception as error:
            del self._futures[number]
            if type(error).__name__ == "KilledWorker":
                return Ended(number, -9, LOST)
            raise RunError(f"--cluster {self._address}: {type(error).__name__}: {error}") from error
        if "refused" in answer:
            raise RunError(f"--cluster {self._address}: {answer['refused']}")
        if "missing" in answer:
            assert self._upload is not None
            self._submit(number, self._upload.contents, answer["worker"])
            return None
        del self._futures[number]
        folder = Path(self._orders[number].folder)
        for name, data in answer.get("results", {}).items():
            *parents, last = Path(name).parts
            if Path(name).is_absolute() or ".." in parents:
                raise RunError(f"--cluster {self._address}: {name} is not a file of a run")
            write(make_folder(folder, *parents) / last, data)
        return Ended(**{**answer["ended"], "attempts": attempts})

    def _submit(self, number: int, contents: Contents | None = None, worker: str | None = None) -> None:
        order = self._orders[number]
        arguments = self._moved(order.arguments)
        self._started += 1
        payload = {
            "order": {**{name: getattr(order, name) for name in Order.__slots__}, "arguments": arguments},
            "transfer": SHARED if self._upload is None else UPLOAD,
            "place": os.getcwd(),
            "files": self._hashes,
            "rehearse": self._rehearse,
        }
        with suppress(Exception):  # found by `wait`
            self._futures[number] = self._client.submit(
                execute,
                payload,
                contents,
                key=f"tickgraph-{os.getpid()}-{id(self)}-{number}-{self._started}",
                pure=False,
                workers=worker,
                allow_other_workers=worker is not None,
            )

    def _moved(self, arguments: Sequence[str]) -> list[str]:
        """A command line with the names that the worker knows."""
        if self._upload is None:
            return list(arguments)
        names = [self._upload.name_of(one) for one in arguments]
        before = ["", *arguments]
        return [names[place] if place == 1 or before[place] in NAMING else one for place, one in enumerate(arguments)]

    def _again(self) -> list[Ended]:
        """The scheduler is gone: reaches it, or another at its address; every run is to be started again."""
        numbers = [*self._futures]
        self._futures.clear()
        self._disconnect()
        self._client = self._connected(time.monotonic() + RECONNECT_S)
        return [Ended(number, -9, AGAIN) for number in numbers]

    def _connected(self, until: float) -> Any:
        from distributed import Client

        while True:
            try:
                return Client(self._address, timeout=CONNECT_S, name="tickgraph")
            except Exception as error:
                if time.monotonic() >= until:
                    raise RunError(f"--cluster {self._address}: no scheduler answers: {error}") from error
                time.sleep(LOOK_S)

    def _disconnect(self) -> None:
        with suppress(Exception):
            self._client.cancel([*self._futures.values()])
        with suppress(Exception):
            self._client.close(timeout=2)


def require_distributed() -> None:
    """Raises UserError without Dask's package."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise UserError("--cluster needs Dask: pip install 'tickgraph[cluster]'") from None
