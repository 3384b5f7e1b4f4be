"""Spoiled files of every kind, given to the commands: none may crash, hang, fill the memory or read elsewhere.

    python tests/robustness/fuzz.py --count 50000 --jobs 2     # overnight; --seed S for others
    python tests/robustness/fuzz.py --seed 1 --case 4711       # one case again, its file kept
    python tests/robustness/fuzz.py --recordings --count 50000 # recordings and folders of runs instead

A case is made by (seed, number) alone. Each job is a process that runs cases one after another; its parent ends it if a
case takes more than 20 s of CPU time or 4 GiB, notes the case and goes on with the next. The page of every 200th
recording is opened in the browser chromium, where there is one: it may complain about nothing and ask for nothing.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import resource
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import IO

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script, it finds `tests` there

from sensors.compiled.kept import user_folder
from tests.robustness import recordings
from tests.robustness.corpus import write_corpus
from tests.robustness.mutations import spoiled

CPU_S, MEMORY = 20, 4 * 2**30
UPDATES = "3"
BROWSED = 200
"""Of so many recordings the page of one is opened."""
CASES = 1000
"""Cases of a process; then a new one takes over."""
COMMANDS: dict[str, Sequence[Sequence[str]]] = {
    "graph.json": (["check", "{}"], ["run", "{}", "--updates", UPDATES], ["explain", "{}"]),
    "graph.yaml": (["check", "{}"], ["run", "{}", "--updates", UPDATES], ["show", "{}"]),
    "cases.test.yaml": (["test", "{}"], ["check", "{}"]),
    "messages.yaml": (["run", "graph.json", "--updates", UPDATES, "--play", "{}"],),
    "OgnHalf.ogn": (["declare", "{}"], ["test", "{}"]),
    "profile.json": (["run", "profiled.json", "--updates", UPDATES],),
    "model.xml": (["run", "modelled.json", "--updates", UPDATES],),
    "scene.usda": (["check", "{}"], ["run", "{}", "--updates", UPDATES], ["convert", "{}", "out.yaml"]),
    "scene.usdc": (["check", "{}"], ["run", "{}", "--updates", UPDATES], ["inspect", "{}"]),
    "run.mcap": (["run", "graph.json", "--updates", UPDATES, "--play", "{}"],),
}
"""What is done with a file of each kind, in this order; `{}` is the file. `declare` reads a declaration."""

_BAD = re.compile(
    r"internal error|Traceback|RuntimeWarning|Fatal|Coding Error|DeprecationWarning|UserWarning|Aborted|^Warning|"
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f]",
    re.MULTILINE,
)


@dataclass
class Found:
    """What went wrong, by what it was."""

    done: int = 0
    commands: Counter[str] = field(default_factory=Counter)
    """By command, and by its exit code (`run 2`)."""
    failures: list[tuple[int, str]] = field(default_factory=list)
    """(case, what)."""

    def add(self, other: Found) -> None:
        """Puts another's findings to these."""
        self.done += other.done
        self.commands += other.commands
        self.failures += other.failures


def fuzz(seed: int, first: int, count: int, keep: Path | None = None, *, of_runs: bool = False) -> Found:
    """Runs cases in a process of its own, started again after each case that ends it. of_runs: those of recordings."""
    found, case = Found(), first
    while case < first + count:
        case = _watched(seed, case, first + count, found, keep, of_runs)
    return found


def _watched(seed: int, first: int, end: int, found: Found, keep: Path | None, of_runs: bool) -> int:
    """Runs cases in one process until they are done or one ends it; the next case."""
    command = [sys.executable, str(Path(__file__)), "--seed", str(seed), "--worker", str(first), str(end)]
    command += ["--recordings"] if of_runs else []
    if keep is not None:
        command += ["--keep", str(keep)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as worker:
        assert worker.stdout is not None
        case, since, lines = first, 0.0, ""
        while True:
            ready, _, _ = select.select([worker.stdout], [], [], 0.5)
            data = os.read(worker.stdout.fileno(), 65536) if ready else None
            *whole, lines = (lines + (data or b"").decode()).split("\n")
            for line in whole:
                what, number, rest = line.split(" ", 2)
                if what == "begin":
                    case, since = int(number), _cpu_s(worker.pid)
                elif what == "end":
                    found.done += 1
                elif what == "ran":
                    found.commands[rest] += 1
                else:
                    found.failures.append((int(number), rest))
            if data == b"":
                if worker.wait() == 0:
                    return end
                found.failures.append((case, f"the process ended with {worker.returncode}"))
                return case + 1
            over = f"{CPU_S} s of CPU time" if _cpu_s(worker.pid) - since > CPU_S else ""
            over = over or (f"{MEMORY >> 30} GiB" if _memory(worker.pid) > MEMORY else "")
            if over:
                worker.kill()
                found.failures.append((case, f"more than {over}"))
                return case + 1


def _cpu_s(pid: int) -> float:
    """CPU time that a process has used [s]."""
    try:
        parts = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(parts[11]) + int(parts[12])) / os.sysconf("SC_CLK_TCK")


def _memory(pid: int) -> int:
    """Bytes that a process holds."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return 0


def work(seed: int, first: int, end: int, keep: Path | None, of_runs: bool) -> None:
    """The job of one process: tells `begin N`, `ran N command code`, `bad N what` and `end N` on stdout."""
    told = os.fdopen(os.dup(1), "w", buffering=1)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory(prefix="fuzz") as temporary, tempfile.TemporaryFile() as output:
        folder = Path(temporary).resolve()
        os.chdir(folder)
        right = {name: path.read_bytes() for name, path in write_corpus(folder).items()}
        _companions(folder)
        reads = _Reads(folder)
        for case in range(first, end):
            told.write(f"begin {case} -\n")
            random = Random(f"{seed}:{case}")
            for arguments in _run_of_case(random, keep, case) if of_runs else _run_case(random, right, keep, case):
                reads.taken()
                code, said = _command(arguments, output)
                outside = reads.taken()
                told.write(f"ran {case} {arguments[0]} {code}\n")
                bad = _BAD.search(said)
                if bad or code not in (0, 1, 2) or outside:
                    line = said[max(0, bad.start() - 80) : bad.end() + 300] if bad else f"{outside or code}"
                    told.write(f"bad {case} {' '.join(arguments)}: {' '.join(line.split())!r}\n")
                    break
            told.write(f"end {case} -\n")


def _companions(folder: Path) -> None:
    """The files that name those which are spoiled."""
    import json

    from tests.robustness.corpus import DOCUMENT, PRIMS

    lidar = {**PRIMS, "/World/Lidar": {"type": "OmniLidar", "config": "profile.json"}}
    (folder / "profiled.json").write_text(json.dumps({**DOCUMENT, "scene": {"prims": lidar}}))
    (folder / "modelled.json").write_text(json.dumps({"tickgraph": 1, "scene": {"mjcf": "model.xml"}}))


def _run_case(random: Random, right: dict[str, bytes], keep: Path | None, case: int) -> Iterator[Sequence[str]]:
    """The commands to run, while the spoiled file lies there."""
    name = random.choice(sorted(right))
    data = spoiled(right[name], Path(name).suffix, random)
    file = Path(name)
    file.write_bytes(data)
    if keep is not None:
        (keep / f"{case}-{name}").write_bytes(data)
    try:
        for arguments in COMMANDS[name]:
            yield [one.replace("{}", name) for one in arguments]
        if name == "graph.json" and random.random() < 0.1:
            yield ["trade", name, "--vary", "lidar.subrays=1", "--duration", "0.05", "--repeat", "1"]
    finally:
        file.write_bytes(right[name])


def _run_of_case(random: Random, keep: Path | None, case: int) -> Iterator[Sequence[str]]:
    """The commands to run on a folder of a run in which a file is spoiled, and now and then a link lies."""
    run, key = Path("run"), Path("elsewhere/key")
    for folder in (run, key.parent):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
    key.write_text("key")
    name = random.choice(recordings.SPOILT)
    data = recordings.spoiled(name, random)
    if name in ("report.json", "metadata.yaml"):
        (run / "rich.mcap").write_bytes(recordings.made("rich.mcap", recordings.messages(), random, right=True))
    (run / name).write_bytes(data)
    if keep is not None:
        (keep / f"{case}-{name}").write_bytes(data)
    if random.random() < 0.2:
        link = run / random.choice(recordings.LINKS)
        link.parent.mkdir(exist_ok=True)
        link.unlink(missing_ok=True)
        link.symlink_to(os.path.abspath(random.choice((key, key.parent, "/dev/zero", "nowhere"))))
    file = str(run / name) if name.startswith("rich") and random.random() < 0.5 else "run"
    browsed = case % BROWSED == 0 and shutil.which("chromium") is not None
    commands: list[Sequence[str]] = [
        ["info", file, *random.choice(([], ["--json"]))],
        ["export", file, "--format", random.choice(recordings.FORMATS), "--out", "run/out"],
        ["recover", file],
        ["view", file],
    ]
    if random.random() < 0.2:
        commands.append(["run", "graph.json", "--updates", UPDATES, "--play", file])
    random.shuffle(commands)
    if browsed:
        commands.sort(key=lambda one: one[0] != "view")
    with contextlib.nullcontext() if browsed else _without_plotly():
        for command in commands[:3]:
            yield command
            yield ["untouched", str(key.parent)]
            if browsed and command[0] == "view":
                pages = (one for one in run.glob("**/view.html") if not one.is_symlink())
                yield from (["browse", str(one)] for one in pages)


@contextlib.contextmanager
def _without_plotly() -> Iterator[None]:
    """Leaves Plotly's 5 MB out of each page."""
    from wings.view import writing

    code, writing.plotly_code = writing.plotly_code, lambda: ""
    try:
        yield
    finally:
        writing.plotly_code = code


def _untouched(folder: str) -> int:
    """1 if something was written through a link into the folder of the key."""
    names = [one.name for one in Path(folder).iterdir()]
    return 0 if names == ["key"] and Path(folder, "key").read_text() == "key" else _FAILED


def _browse(page: str) -> int:
    """Opens a page; says what it complains about or asks for."""
    from tests.support.browser import browse

    with (
        tempfile.TemporaryDirectory(dir=".", ignore_cleanup_errors=True) as profile,
        browse(os.path.abspath(page), os.path.abspath(profile)) as shown,
    ):
        wrong = [*shown.complaints(), *shown.requests()]
    print(*wrong, sep="\n")
    return _FAILED if wrong else 0


def _command(arguments: Sequence[str], output: IO[bytes]) -> tuple[int, str]:
    """Exit code and output of a command run in this process, also of what C libraries write."""
    from graph.cli.main import main

    output.seek(0)
    output.truncate()
    with _into(output.fileno()):
        own = _OWN.get(arguments[0])
        code = own(arguments[1]) if own else main(list(arguments))
        sys.stdout.flush()
        sys.stderr.flush()
    output.seek(0)
    return code, output.read().decode("utf-8", "replace")


def _declare(name: str) -> int:
    from graph.base.errors import UserError
    from graph.ogn.reading import read_ogn

    try:
        read_ogn(Path(name).read_text(encoding="utf-8", errors="replace"), name=name)
    except UserError:
        return 2
    return 0


_FAILED = 3
"""An exit code that no command has."""
_OWN: dict[str, Callable[[str], int]] = {"declare": _declare, "untouched": _untouched, "browse": _browse}
"""What is done with a file besides the commands of `graph`."""


@contextlib.contextmanager
def _into(descriptor: int) -> Iterator[None]:
    saved = os.dup(1), os.dup(2)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    try:
        yield
    finally:
        for number, old in enumerate(saved, 1):
            os.dup2(old, number)
            os.close(old)


WRITES = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod")
"""Audit events that change the file system at their first argument."""
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC


class _Reads:
    """Which files Python opened or changed that are neither the case's nor, to read, the installation's."""

    def __init__(self, folder: Path) -> None:
        here = Path(__file__).resolve().parents[2]
        places = [
            folder,
            here,
            Path(sys.prefix),
            Path(sys.base_prefix),
            *map(Path, sys.path),
            Path("/usr"),
            Path("/sys"),
            user_folder(),  # compiled loops, which are read only from a folder that is the user's alone
        ]
        self._allowed = tuple(f"{place.resolve()}/" for place in places if str(place) not in ("", "."))
        cache = os.environ.get("TICKGRAPH_CACHE") or os.path.expanduser("~/.cache")
        self._writable = (f"{folder}/", "/dev/null", f"{os.path.realpath(cache)}/", f"{here}/")
        self._folder = folder
        self._found: list[str] = []
        sys.addaudithook(self._see)

    def _see(self, event: str, arguments: tuple[object, ...]) -> None:
        if event not in ("open", *WRITES) or not isinstance(arguments[0], (str, bytes)):
            return
        path = os.path.join(self._folder, os.fsdecode(arguments[0]))
        folder, name = os.path.split(path)
        # Removing and renaming act on a link itself.
        real = os.path.realpath(path) if event == "open" else os.path.join(os.path.realpath(folder), name)
        writes = event != "open" or bool(isinstance(arguments[2], int) and arguments[2] & WRITING)
        allowed = self._writable if writes else (*self._allowed, "/proc/", "/dev/null", "/dev/zero", "/etc/localtime")
        if real != str(self._folder) and not real.startswith(allowed):
            self._found.append(f"{path} ({event})")

    def taken(self) -> list[str]:
        """The files since the last call."""
        found, self._found = self._found, []
        return found


def main() -> int:
    """The command; exit code 1 if anything was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=1000, help="cases to run")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--case", type=int, help="run one case and show what comes of it")
    parser.add_argument("--recordings", action="store_true", help="spoil recordings and folders of runs")
    parser.add_argument("--keep", type=Path, help="folder for the spoiled files")
    parser.add_argument("--worker", nargs=2, type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.worker:
        first, count = args.worker
        work(args.seed, first, count, args.keep, args.recordings)
        return 0
    if args.case is not None:
        args.first, args.count, args.keep = args.case, 1, args.keep or Path()
    from concurrent.futures import ThreadPoolExecutor

    started, found = time.monotonic(), Found()
    size = max(1, min(CASES, args.count // args.jobs))
    parts = [
        (first, min(size, args.first + args.count - first))
        for first in range(args.first, args.first + args.count, size)
    ]
    with ThreadPoolExecutor(args.jobs) as jobs:
        for part in jobs.map(lambda one: fuzz(args.seed, one[0], one[1], args.keep, of_runs=args.recordings), parts):
            found.add(part)
            for case, what in part.failures:
                print(f"case {case}: {what}", flush=True)
            if found.done // 1000 > (found.done - part.done) // 1000:
                print(f"{found.done:,} files, {len(found.failures)} failures so far", file=sys.stderr, flush=True)
    for what, count in sorted(found.commands.items()):
        print(f"{count:8,} {what}")
    print(f"{found.done:,} files in {time.monotonic() - started:.0f} s; {len(found.failures)} failures")
    return 1 if found.failures else 0


if __name__ == "__main__":
    sys.exit(main())
