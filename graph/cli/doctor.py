"""`graph doctor`: checks whether this machine is ready, and says what to install."""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

from graph.base.errors import UserError
from graph.base.work import usable_cores

from . import extremes
from .printing import counted, say, say_json, tell
from .progress import counting

HELP = "is this machine ready? what to install"

MINIMUM_PYTHON = (3, 11)
MINIMUM_GLIBC = (2, 35)
GIB = 2**30
LITTLE_MEMORY = 2 * GIB
LITTLE_DISK = GIB

IMPORTS = {
    "PIL.Image": ("pillow",),
    "libusb_package": ("libusb-package",),
    "lz4.frame": ("lz4",),
    "mapbox_earcut": ("mapbox-earcut",),
    "matplotlib": ("matplotlib",),
    "mcap.writer": ("mcap",),
    "mujoco": ("mujoco-core", "mujoco"),
    "networkx": ("networkx",),
    "numba": ("numba",),
    "numpy": ("numpy",),
    "open3d": ("open3d-cpu", "open3d"),
    "pxr.Usd": ("usd-core",),
    "platformdirs": ("platformdirs",),
    "rich": ("rich",),
    "rosbags.typesys": ("rosbags",),
    "ruamel.yaml": ("ruamel.yaml",),
    "shtab": ("shtab",),
}
"""Modules to import, and the distributions that may provide them."""

HEAVY = ("mujoco", "numba", "open3d", "pxr.Usd")
"""Modules that are imported only at first use, each by one file of ours."""

LAZY_PROBE = """
import sys, time
start = time.perf_counter()
import graph, graph.sim, nodes, sensors
heavy = ("mujoco", "numba", "open3d", "pxr", "matplotlib")
print(time.perf_counter() - start, *(name for name in heavy if name in sys.modules))
"""

PROBE = """
import sys, time
start = time.perf_counter()
if sys.argv[1] == "open3d":
    from graph.sim.libraries import import_open3d
    import_open3d()
else:
    __import__(sys.argv[1])
print(time.perf_counter() - start)
"""
"""The code that a fresh interpreter runs for one module, because an import that crashes must not end the doctor."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One result:

    `state` is "ok", "warn" (works, but with little of it) or "fail" (not ready; `advice` says what to do).

    import_s: the time [s] in which a fresh interpreter imports it, if it is a module.
    """

    name: str
    state: str
    detail: str
    advice: str = ""
    import_s: float | None = None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the options of `graph doctor`."""
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")
    parser.add_argument("--warm", action="store_true", help="compile the sensors' loops now, on all cores")
    parser.add_argument(
        "--device",
        nargs="?",
        const="cuda",
        metavar="NAME",
        help="check a device (cuda, cuda:N, warp-cpu): its memory, and rays against the processor's",
    )
    extremes.add_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Checks everything and prints it; returns 0 if the machine is ready, else 1."""
    if args.stability:
        return extremes.run(args)
    if args.warm:
        return _warm()
    if args.device:
        return _check_device(args.device, as_json=args.json)
    if args.only:
        raise UserError("--only chooses among the cases of --stability; add it")
    findings = examine()
    ready = all(finding.state != "fail" for finding in findings)
    if args.json:
        say_json({"ready": ready, "findings": [asdict(finding) for finding in findings]})
    else:
        width = max(len(finding.name) for finding in findings)
        for finding in findings:
            say(f"{finding.state:4}  {finding.name:{width}}  {finding.detail}")
        advice = dict.fromkeys(finding.advice for finding in findings if finding.advice)
        for line in ("ready" if ready else "not ready", *(f"  {line}" for line in advice)):
            say(line)
    return 0 if ready else 1


def examine() -> list[Finding]:
    """All findings, in the order they are printed."""
    modules = map(_dependency, IMPORTS)
    own = (_lazy_loading(), _compiled_loops())
    return [_python(), _glibc(), _system_libraries(), *modules, *own, _cores(), _memory(), _disk()]


def _python() -> Finding:
    detail = f"{platform.python_version()} ({platform.python_implementation()}, {platform.machine()}, {sys.executable})"
    if sys.version_info[:2] < MINIMUM_PYTHON:
        return Finding("python", "fail", detail, f"Install Python {'.'.join(map(str, MINIMUM_PYTHON))} or newer.")
    return Finding("python", "ok", detail)


def _glibc() -> Finding:
    name, version = platform.libc_ver()
    if name != "glibc":
        return Finding("C library", "ok", name or platform.system())
    if tuple(int(part) for part in version.split(".")[:2]) < MINIMUM_GLIBC:
        return Finding(
            "C library", "fail", f"glibc {version}", "Open3D needs glibc 2.35: use Debian 12, Ubuntu 22.04 or newer."
        )
    return Finding("C library", "ok", f"glibc {version}")


def _system_libraries() -> Finding:
    from graph.sim.libraries import INSTALL_HINT, SYSTEM_LIBRARIES, missing_system_libraries

    missing = missing_system_libraries()
    if missing:
        return Finding("system libraries", "fail", f"missing: {', '.join(missing)}", f"Run as root: {INSTALL_HINT}")
    return Finding(
        "system libraries", "ok", ", ".join(SYSTEM_LIBRARIES) if sys.platform.startswith("linux") else "none needed"
    )


def _dependency(module: str) -> Finding:
    distributions = IMPORTS[module]
    version = next(filter(None, map(_version, distributions)), None)
    name = distributions[0]
    if version is None:
        return Finding(name, "fail", "not installed", f"Run: pip install {name}")
    probe = _fresh(PROBE, module)
    if probe.returncode != 0:
        said = (probe.stderr.strip().splitlines() or [f"ended with status {probe.returncode}"])[-1]
        _, is_ours, ours = said.partition("UserError: ")  # the message says what to do
        advice = "" if is_ours else f"Run: pip install --force-reinstall {name}"
        return Finding(name, "fail", f"{version} does not import: {ours or said}", advice)
    seconds = float(probe.stdout.split()[-1])
    when = ", on first use" if module in HEAVY else ""
    return Finding(name, "ok", f"{version}, imports in {seconds:.2f} s{when}", import_s=round(seconds, 4))


def _lazy_loading() -> Finding:
    """Whether our own packages are imported without the heavy libraries."""
    probe = _fresh(LAZY_PROBE)
    if probe.returncode != 0:
        said = (probe.stderr.strip().splitlines() or [f"ended with status {probe.returncode}"])[-1]
        return Finding("tickgraph", "fail", f"does not import: {said}", "Run: pip install --force-reinstall tickgraph")
    seconds, *loaded = probe.stdout.split()
    detail = f"imports in {float(seconds):.2f} s"
    if loaded:
        return Finding("tickgraph", "warn", f"{detail} and loads {', '.join(loaded)} with it", import_s=float(seconds))
    return Finding("tickgraph", "ok", f"{detail}, without the heavy libraries", import_s=round(float(seconds), 4))


def _compiled_loops() -> Finding:
    """Whether the sensors' loops are compiled once a machine, or in every run."""
    from sensors.compiled.kept import user_folder, why_not_kept

    reason = why_not_kept()
    if reason:
        advice = "Set TICKGRAPH_CACHE to a folder of your own, or each run compiles the sensors' loops again."
        return Finding("compiled loops", "warn", f"cannot be kept: {reason}", advice)
    return Finding("compiled loops", "ok", f"kept in {user_folder()}; --warm compiles them ahead")


def _fresh(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs code in a new interpreter."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-P", "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


def _version(distribution: str) -> str | None:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


def _cores() -> Finding:
    return Finding("cores", "ok", f"{usable_cores()} usable of {os.cpu_count()}")


def _memory() -> Finding:
    try:
        page = os.sysconf("SC_PAGE_SIZE")
        total, free = page * os.sysconf("SC_PHYS_PAGES"), page * os.sysconf("SC_AVPHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return Finding("memory", "ok", "unknown on this system")
    detail = f"{total / GIB:.1f} GiB, {free / GIB:.1f} GiB free"
    if total < LITTLE_MEMORY:
        return Finding("memory", "warn", detail, "Large scenes want 2 GiB of memory or more.")
    return Finding("memory", "ok", detail)


def _disk() -> Finding:
    free = shutil.disk_usage(".").free
    detail = f"{free / GIB:.1f} GiB free here"
    if free < LITTLE_DISK:
        return Finding("disk", "warn", detail, "Recordings want space: free some, or give --out another disk.")
    return Finding("disk", "ok", detail)


def _check_device(name: str, *, as_json: bool) -> int:
    """Checks a device; returns 0 if rays can be cast there, else 1. Raises UserError if it is missing."""
    from graph.sim.devices import plugin_of, warp

    if name == "cpu":
        raise UserError("doctor --device cpu: the processor needs no check of its own; name cuda, cuda:N or warp-cpu")
    plugin, wp = plugin_of(name), warp()
    device, found = plugin.device_of(name), plugin.compare(name)
    facts = {
        "device": device.name,
        "warp": wp.config.version,
        "ready": found.same,
        "rays": found.rays,
        "range_difference_m": found.worst_m,
        "other_surfaces": found.others,
    }
    if device.is_cuda:
        driver = wp.get_cuda_driver_version()
        facts |= {
            "driver": ".".join(map(str, driver)) if isinstance(driver, tuple) else str(driver),
            "memory_gib": round(device.total_memory / GIB, 1),
            "free_gib": round(device.free_memory / GIB, 1),
        }
    if as_json:
        say_json(facts)
        return 0 if found.same else 1
    memory = (
        f", {facts['free_gib']} of {facts['memory_gib']} GiB free, CUDA {facts['driver']}" if device.is_cuda else ""
    )
    say(f"{name}  {device.name}{memory}, Warp {wp.config.version}")
    say(f"{found.rays:,} rays as on the processor: ranges within {found.worst_m:.1e} m, other surfaces: {found.others}")
    say("ready" if found.same else "not ready: it measures something else; report it with this output")
    return 0 if found.same else 1


def _warm() -> int:
    """Compiles what is missing, with a bar on a terminal; returns 0."""
    from sensors.compiled.kept import user_folder, why_not_kept
    from sensors.compiled.warming import warm

    reason = why_not_kept()
    if reason:
        say(f"compiled code cannot be kept: {reason}. Set TICKGRAPH_CACHE to a folder of your own")
        return 1
    start = time.monotonic()
    number = 0
    with counting("compiling", shown=sys.stderr.isatty()) as bar:
        for done, number in warm():
            if number and not done and not sys.stderr.isatty():
                tell(f"compiling {counted(number, 'loops')} of the sensors, once on this machine")
            bar.update(bar.task_ids[0], completed=done, total=number)
    if not number:
        say("the sensors' loops are compiled already")
    else:
        say(f"compiled {counted(number, 'loops')} in {time.monotonic() - start:.0f} s into {user_folder()}")
    return 0
