"""The settings tree: `/path/to/setting` to value, with the defaults of the `base` experience."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from graph.base import exact
from graph.base.callables import check_callable
from graph.base.errors import Mark, Problem, UserError
from graph.base.suggest import closest
from graph.base.suggesting import Suggesting

RATE_LIMIT_ENABLED = "/app/runLoops/main/rateLimitEnabled"
RATE_LIMIT_FREQUENCY = "/app/runLoops/main/rateLimitFrequency"
MANUAL_MODE = "/app/runLoops/main/manualModeEnabled"
FIXED_STEPPING = "/app/player/useFixedTimeStepping"
FAST_MODE = "/app/player/useFastMode"
TARGET_FRAMERATE = "/app/player/targetRunLoopFrequency"
TICKS_PER_FRAME = "/app/player/timelineSubsampleRate"
PLAY_SIMULATIONS = "/app/player/playSimulations"
CAPTURE_ON_PLAY = "/omni/replicator/captureOnPlay"
TIME_CODES_PER_SECOND = "/app/stage/timeCodesPerSecond"
MIN_FRAME_RATE = "/persistent/simulation/minFrameRate"
MULTI_TICK = "/rtx/hydra/supportMultiTickRate"
SENSOR_TICK_TLAS = "/rtx/rendering/perSensorTickTlas"
RENDER_COMPLETE_ORDER = "/app/updateOrder/checkForHydraRenderComplete"
PLAY_DELAY = "/app/player/CompensatePlayDelayInSecs"
INTERRUPTS_OFF = "/ext/omni.graph.action/disableInterrupts"
RAY_THREADS = "/tickgraph/rayThreads"
WHEN_PLAYING = "/tickgraph/whenPlaying"
WARM_UP_STEPS = "/tickgraph/warmUpSteps"
TRUNCATE_STEPS = "/tickgraph/truncateStepsPerSecond"
SAMPLE_SUBSTEPS = "/tickgraph/timeSamplePerSubstep"
SET_DT_RATE_LIMIT = "/tickgraph/setDtSetsRateLimit"
REWRITE_RATE_LIMIT = "/tickgraph/playRewritesRateLimit"
AUTOTRIGGER_IDLE = "/tickgraph/autotriggerWithoutStep"
BARE_LIDAR_TICK_RATE = "/tickgraph/bareLidarTickRate"
FRAMES_LATER = "/tickgraph/framesOneUpdateLater"
FULL_SCAN_WARNS = "/tickgraph/fullScanWarnsWhen"
SCAN_EMPTY_MINUS_ONE = "/tickgraph/laserScanEmptyIsMinusOne"
LIDAR_HEADER = "/tickgraph/lidarHeader"
HEADER_FRAME, HEADER_SCAN_START, HEADER_UPDATE = "frame", "scanStart", "update"
FRAME_ID_AS_GIVEN = "/tickgraph/frameIdAsGiven"
SCAN_BINS = "/tickgraph/laserScanBinsOfFieldOfView"
SCAN_END_BEYOND = "/tickgraph/laserScanEndsBeyondLastBeam"
FLAT_SCAN_NEEDS_2D = "/tickgraph/flatScanNeeds2d"
BOXES_IN_WORLD = "/tickgraph/cameraBoxesInWorld"
INFO_SQUARE_PIXELS = "/tickgraph/cameraInfoSquarePixels"
CLOUD_OF_CORNERS = "/tickgraph/cameraCloudOfCorners"
MERGE_TRANSFORMS = "/tickgraph/mergeTransforms"
ODOMETRY_WORLD_TURN = "/tickgraph/odometryWorldTurn"
STOP_CLEARS_COMMANDS = "/tickgraph/stopClearsCommands"
NODE_ERRORS_STOP = "/tickgraph/nodeErrorsStop"
ID_MAP_EXTENSION = "/tickgraph/idMapExtension"
RADAR_IGNORES_TICK_RATE = "/tickgraph/radarIgnoresTickRate"
RADAR_NEEDS_MOTION_BVH = "/tickgraph/radarNeedsMotionBvh"
CAMERA_TONE = "/tickgraph/cameraTone"
TONE_LINEAR, TONE_ACES = "linear", "aces"
MOTION_BVH = "/renderer/raytracingMotion/enabled"
ACCEPTED_FINDINGS = "/tickgraph/acceptedFindings"
"""Codes, with spaces between, that `graph check --target` does not report for this file: its author knows of them."""

DEFAULTS: dict[str, Any] = {
    RATE_LIMIT_ENABLED: False,
    RATE_LIMIT_FREQUENCY: 60,
    MANUAL_MODE: True,
    FIXED_STEPPING: False,
    FAST_MODE: False,
    TARGET_FRAMERATE: 60,
    TICKS_PER_FRAME: 1,
    PLAY_DELAY: 0.0,
    PLAY_SIMULATIONS: True,
    CAPTURE_ON_PLAY: True,
    TIME_CODES_PER_SECOND: 60,
    MIN_FRAME_RATE: 0,
    MULTI_TICK: True,
    SENSOR_TICK_TLAS: True,
    "/app/hydraEngine/waitIdle": False,
    RENDER_COMPLETE_ORDER: -100,
    "/app/settings/fabricDefaultSimPeriodNumerator": 1,
    "/app/settings/fabricDefaultSimPeriodDenominator": 30,
    "/app/settings/fabricDefaultStageFrameHistoryCount": 3,
    "/persistent/physics/resetOnStop": True,
    "/exts/isaacsim.core.simulation_manager/default_engine": "mujoco",
    INTERRUPTS_OFF: True,
    WHEN_PLAYING: "refuse",
    RAY_THREADS: 0,
    WARM_UP_STEPS: 0,
    TRUNCATE_STEPS: False,
    SAMPLE_SUBSTEPS: False,
    SET_DT_RATE_LIMIT: True,
    REWRITE_RATE_LIMIT: False,
    AUTOTRIGGER_IDLE: False,
    BARE_LIDAR_TICK_RATE: 0,
    FRAMES_LATER: False,
    FULL_SCAN_WARNS: False,
    SCAN_EMPTY_MINUS_ONE: False,
    SCAN_END_BEYOND: False,
    LIDAR_HEADER: HEADER_FRAME,
    FRAME_ID_AS_GIVEN: False,
    SCAN_BINS: False,
    FLAT_SCAN_NEEDS_2D: True,
    BOXES_IN_WORLD: False,
    INFO_SQUARE_PIXELS: False,
    CLOUD_OF_CORNERS: False,
    MERGE_TRANSFORMS: True,
    ODOMETRY_WORLD_TURN: False,
    STOP_CLEARS_COMMANDS: False,
    NODE_ERRORS_STOP: True,
    ID_MAP_EXTENSION: True,
    RADAR_IGNORES_TICK_RATE: False,
    RADAR_NEEDS_MOTION_BVH: False,
    CAMERA_TONE: TONE_LINEAR,
    ACCEPTED_FINDINGS: "",
}
"""Values of the `documented` profile (`graph.sim.timing.parity` has the other one).

`minFrameRate` 0 means no catch-up cap, `rayThreads` 0 means all cores.
"""

SWITCHES = (MOTION_BVH, "/rtx-transient/stableIds/enabled", "/app/sensors/nv/lidar/publishNormals")
"""Settings that are on or off and have no default."""

KNOWN = (
    *DEFAULTS,
    *SWITCHES,
    "/rtx/materialDb/nonVisualMaterialSemantics/prefix",
)
"""Every setting that TickGraph reads."""

_RATES = {RATE_LIMIT_FREQUENCY, TARGET_FRAMERATE, TIME_CODES_PER_SECOND}
_NOT_NEGATIVE = {BARE_LIDAR_TICK_RATE, PLAY_DELAY}
_CHOICES = {
    LIDAR_HEADER: (HEADER_FRAME, HEADER_SCAN_START, HEADER_UPDATE),
    CAMERA_TONE: (TONE_LINEAR, TONE_ACES),
}
_COUNTS = {MIN_FRAME_RATE, RAY_THREADS, WARM_UP_STEPS, TICKS_PER_FRAME}
_TRUTH = {"true": True, "false": False, "1": True, "0": False, "on": True, "off": False, "yes": True, "no": False}


_MOST_SUGGESTIONS = 200
"""Most settings of a file that are checked for misspellings."""


class Settings(Suggesting):
    """A tree of settings. Any path may be set; the known ones in `DEFAULTS` keep their type and range."""

    def __init__(self, values: Mapping[str, Any] | None = None, defaults: Mapping[str, Any] = DEFAULTS) -> None:
        self._values: dict[str, Any] = dict(defaults)
        self._branches = {parent for path in self._values for parent in _above(path)}
        self._authored: set[str] = set()
        self._read: set[str] = set()
        self._subscribers: dict[str, list[Callable[[Any], None]]] = {}
        self._tell_misspelt: Callable[[str, str], None] | None = None
        problems: list[Problem] = []
        for path, value in (values or {}).items():
            try:
                self.set(path, value)
            except UserError as error:
                problems.extend(error.problems)
        if problems:
            raise UserError(problems)

    def get(self, path: str, default: Any = None) -> Any:
        """The value at `path`; for a branch, a dict of everything below it; else `default`."""
        if path not in KNOWN:  # those are normalised
            path = normalised(path)
            self._read.add(path)
        if path in self._values:
            return self._values[path]
        return self._branch(path) or default

    def set(self, path: str, value: Any) -> None:
        """Sets a value (a dict sets the leaves below `path`) and calls the subscribers if it changed.

        Raises UserError for an invalid path or a value that a known setting does not accept.
        """
        path = normalised(path)
        if isinstance(value, Mapping):
            for key, below in value.items():
                self.set(f"{path}/{key}", below)
            return
        self._refuse_mixing(path)
        value = _checked(path, value)
        new = path not in self._values
        changed = new or self._values[path] != value
        self._values[path] = value
        self._branches.update(_above(path))
        self._authored.add(path)
        if new and self._tell_misspelt is not None and (known := suggestion(path)):
            self._tell_misspelt(path, known)
        if changed:
            for callback in tuple(self._subscribers.get(path, ())):
                callback(value)

    def set_default(self, path: str, value: Any) -> None:
        """Sets a value unless the user has set one."""
        path = normalised(path)
        if path not in self._authored:
            self.set(path, value)
            self._authored.discard(path)

    def is_authored(self, path: str) -> bool:
        """Whether the user, rather than a default, gave the value."""
        return normalised(path) in self._authored

    def is_read(self, path: str) -> bool:
        """Whether something reads the setting: a part of this package, or so far a `get` or a subscriber."""
        path = normalised(path)
        return path in KNOWN or not self._read.isdisjoint((path, *_above(path))) or bool(self._subscribers.get(path))

    def rate(self, path: str) -> Fraction:
        """The value as an exact number [Hz]."""
        return exact.rate(self._values[normalised(path)])

    def on_misspelt(self, tell: Callable[[str, str], None]) -> None:
        """Calls `tell(path, known)` for each setting, present or future, that looks like a misspelt known one."""
        for path in sorted(self._authored)[:_MOST_SUGGESTIONS]:
            if known := suggestion(path):
                tell(path, known)
        self._tell_misspelt = tell

    def subscribe(self, path: str, callback: Callable[[Any], None]) -> Callable[[], None]:
        """Calls `callback(value)` when the value at `path` changes; returns a function that ends it."""
        check_callable(callback, "settings.subscribe(path, callback)")
        callbacks = self._subscribers.setdefault(normalised(path), [])
        callbacks.append(callback)

        def unsubscribe() -> None:
            if callback in callbacks:
                callbacks.remove(callback)

        return unsubscribe

    def close(self) -> None:
        """Ends all subscriptions."""
        self._subscribers.clear()
        self._tell_misspelt = None

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._values))

    def _branch(self, path: str) -> dict[str, Any]:
        tree: dict[str, Any] = {}
        prefix = path.rstrip("/") + "/"
        for leaf in self:
            if leaf.startswith(prefix):
                *folders, name = leaf[len(prefix) :].split("/")
                inner = tree
                for folder in folders:
                    inner = inner.setdefault(folder, {})
                inner[name] = self._values[leaf]
        return tree

    def _refuse_mixing(self, path: str) -> None:
        leaf = next((parent for parent in _above(path) if parent in self._values), None)
        if leaf is not None:
            raise UserError(f"setting {path}: {leaf} already holds a value; it cannot also have settings below it")
        if path not in self._values and path in self._branches:
            raise UserError(f"setting {path}: it has settings below it; set one of those")


def _above(path: str) -> list[str]:
    """The branches that contain a path, from the root on."""
    return [path[:place] for place, letter in enumerate(path) if letter == "/" and place]


def parse_option(text: str) -> tuple[str, Any]:
    """`--/path=value` (the dashes may be missing) as path and typed value.

    true/false, integers, decimals and fractions are typed; quotes force text. Raises UserError.
    """
    path, equals, value = text.removeprefix("--").partition("=")
    if not equals:
        raise UserError(f"setting {text}: no value given; write it as --/path/to/setting=value")
    return normalised(path), parse_value(value)


def parse_value(text: str) -> Any:
    """The typed value that a command-line text stands for."""
    text = text.strip()
    if len(text) >= 2 and text[0] == text[-1] and text[0] in "\"'":
        return text[1:-1]
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def normalised(path: str) -> str:
    """The path with one leading slash and without a trailing slash. Raises UserError if it is not a setting path."""
    parts = path.strip().strip("/").split("/")
    if not all(parts) or any(part != part.strip() for part in parts):
        raise UserError(f"setting {path!r} is not a path; write it as /path/to/setting")
    return "/" + "/".join(parts)


def suggestion(path: str) -> str | None:
    """The known setting that `path` probably means; None for known ones and for those of other tools.

    Beside a known setting, in the same folder, a name may differ more; below `/tickgraph` all settings are ours.
    """
    if path in KNOWN:
        return None
    folder, _, name = path.rpartition("/")
    beside = {known.rpartition("/")[2]: known for known in KNOWN if known.rpartition("/")[0] == folder}
    near = closest(name, beside, 0.3 if folder == "/tickgraph" else 0.75)
    return closest(path, KNOWN, 0.9) if near is None else beside[near]


def from_mapping(values: Mapping[str, Any], where: Callable[[str], Mark | None] = lambda path: None) -> Settings:
    """Settings from a file's `settings:` block. Raises UserError with all problems, each with its mark."""
    settings = Settings()
    problems: list[Problem] = []
    for path, value in values.items():
        try:
            settings.set(path, value)
        except UserError as error:
            problems.extend(Problem(problem.message, where(path)) for problem in error.problems)
    if problems:
        raise UserError(problems)
    return settings


def _checked(path: str, value: Any) -> Any:
    if path not in DEFAULTS and path not in SWITCHES:
        return value
    default = DEFAULTS.get(path, False)
    if path in _CHOICES and value not in _CHOICES[path]:
        raise UserError(f"setting {path}: {value!r} is not one of {', '.join(_CHOICES[path])}")
    if path in _RATES or path in _COUNTS or path in _NOT_NEGATIVE:
        return _checked_number(path, value)
    if isinstance(default, bool):
        truth = value if isinstance(value, bool) else _TRUTH.get(str(value).lower())
        if truth is None:
            raise UserError(f"setting {path}: {value!r} is neither true nor false")
        return truth
    if isinstance(default, (int, float)):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise UserError(f"setting {path}: {value!r} is not a number")
        return value
    return str(value)


def _checked_number(path: str, value: Any) -> Any:
    try:
        number = exact.rate(value)
    except (ValueError, TypeError):
        raise UserError(f"setting {path}: {value!r} is not a number or a fraction such as 60000/1001") from None
    if path in _RATES and number <= 0:
        raise UserError(f"setting {path}: {value!r} must be greater than 0")
    if path in _NOT_NEGATIVE and number < 0:
        raise UserError(f"setting {path}: {value!r} must be 0 or greater")
    if path == TICKS_PER_FRAME and number == 0:
        raise UserError(f"setting {path}: {value!r} must be 1 or more")
    if path in _COUNTS and (number < 0 or number.denominator != 1):
        raise UserError(f"setting {path}: {value!r} must be a whole number, 0 or more")
    return number if isinstance(value, str) else value
