"""The settings tree: `/path/to/setting` to value, with the defaults of the `base` experience.

A profile only changes defaults: values that a user sets, by file, command line or API, are preferred.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from graph.base import exact
from graph.base.callables import check_callable
from graph.base.errors import Mark, Problem, UserError
from graph.base.suggest import closest
from graph.base.suggesting import Suggesting

DOCUMENTED, PRODUCT = "documented", "isaacsim-6.0.1"
PARITIES = (DOCUMENTED, PRODUCT)
"""The profiles: what Isaac Sim's documentation says, and what the product does."""

DEFAULTS: dict[str, Any] = {}
"""By setting, its value in the profile `documented`."""

PRODUCT_DEFAULTS: dict[str, Any] = {}
"""By setting, its value in the profile `isaacsim-6.0.1`, if that differs.

Both profiles ignore the trigger that would interrupt a sleeping latent node;
`/ext/omni.graph.action/disableInterrupts = false` lets it interrupt.
"""


def _setting(path: str, default: Any, product: Any = None) -> str:
    """Declares a known setting; returns its path."""
    DEFAULTS[path] = default
    if product is not None:
        PRODUCT_DEFAULTS[path] = product
    return path


HEADER_FRAME, HEADER_SCAN_START, HEADER_UPDATE = "frame", "scanStart", "update"
TONE_LINEAR, TONE_ACES = "linear", "aces"

# Below a setting whose default depends on the profile: what its two values mean, the documented one first.

RATE_LIMIT_ENABLED = _setting("/app/runLoops/main/rateLimitEnabled", False)
RATE_LIMIT_FREQUENCY = _setting("/app/runLoops/main/rateLimitFrequency", 60, product=120)
"""Updates a second of wall time, unless set."""
MANUAL_MODE = _setting("/app/runLoops/main/manualModeEnabled", True)
FIXED_STEPPING = _setting("/app/player/useFixedTimeStepping", False)
FAST_MODE = _setting("/app/player/useFastMode", False)
TARGET_FRAMERATE = _setting("/app/player/targetRunLoopFrequency", 60)
TICKS_PER_FRAME = _setting("/app/player/timelineSubsampleRate", 1)
PLAY_DELAY = _setting("/app/player/CompensatePlayDelayInSecs", 0.0)
PLAY_SIMULATIONS = _setting("/app/player/playSimulations", True)
CAPTURE_ON_PLAY = _setting("/omni/replicator/captureOnPlay", True)
TIME_CODES_PER_SECOND = _setting("/app/stage/timeCodesPerSecond", 60)
MIN_FRAME_RATE = _setting("/persistent/simulation/minFrameRate", 0, product=30)
"""Catch-up cap: max(1, sps // this) steps an update; 0: no cap."""
MULTI_TICK = _setting("/rtx/hydra/supportMultiTickRate", True)
SENSOR_TICK_TLAS = _setting("/rtx/rendering/perSensorTickTlas", True)
_setting("/app/hydraEngine/waitIdle", False)
RENDER_COMPLETE_ORDER = _setting("/app/updateOrder/checkForHydraRenderComplete", -100)
_setting("/app/settings/fabricDefaultSimPeriodNumerator", 1)
_setting("/app/settings/fabricDefaultSimPeriodDenominator", 30)
_setting("/app/settings/fabricDefaultStageFrameHistoryCount", 3)
_setting("/persistent/physics/resetOnStop", True)
_setting("/exts/isaacsim.core.simulation_manager/default_engine", "mujoco")
INTERRUPTS_OFF = _setting("/ext/omni.graph.action/disableInterrupts", True)
WHEN_PLAYING = _setting("/tickgraph/whenPlaying", "refuse")
RAY_THREADS = _setting("/tickgraph/rayThreads", 0)
"""0 means all cores."""
WARM_UP_STEPS = _setting("/tickgraph/warmUpSteps", 0, product=2)
"""Physics steps that a play from stopped runs before the first update."""
TRUNCATE_STEPS = _setting("/tickgraph/truncateStepsPerSecond", False, product=True)
"""Steps per second of a dt: exactly 1/dt, or int(1/dt), which loses a step for 1/93."""
SAMPLE_SUBSTEPS = _setting("/tickgraph/timeSamplePerSubstep", False, product=True)
"""Time samples: one an update with its exact time as key; or one a substep, keys in whole microseconds, and the
simulation time at t is t itself.
"""
SET_DT_RATE_LIMIT = _setting("/tickgraph/setDtSetsRateLimit", True, product=False)
"""`set_dt` sets rateLimitFrequency and targetFramerate always, or only while rateLimitEnabled."""
REWRITE_RATE_LIMIT = _setting("/tickgraph/playRewritesRateLimit", False, product=True)
"""Play in fixed stepping sets rateLimitFrequency to N x timeCodesPerSecond."""
AUTOTRIGGER_IDLE = _setting("/tickgraph/autotriggerWithoutStep", False, product=True)
"""In an update without a physics step nothing renders, or autotrigger sensors (tickRate 0) do."""
BARE_LIDAR_TICK_RATE = _setting("/tickgraph/bareLidarTickRate", 0, product=10)
"""The tickRate [Hz] of a lidar prim that authors none."""
FRAMES_LATER = _setting("/tickgraph/framesOneUpdateLater", False, product=True)
"""Frames arrive in the update that renders them, or at the begin of the next one; the latter unless
checkForHydraRenderComplete comes after rendering, as in the experience zero_delay.
"""
FULL_SCAN_WARNS = _setting("/tickgraph/fullScanWarnsWhen", False, product=True)
"""The value of the lidar helper's fullScan that gives the deprecation warning."""
SCAN_EMPTY_MINUS_ONE = _setting("/tickgraph/laserScanEmptyIsMinusOne", False, product=True)
"""An empty beam of a LaserScan is +inf, or -1."""
SCAN_END_BEYOND = _setting("/tickgraph/laserScanEndsBeyondLastBeam", False, product=True)
"""The angle_max of a LaserScan is the last beam's angle, or one increment beyond it."""
LIDAR_HEADER = _setting("/tickgraph/lidarHeader", HEADER_FRAME, product=HEADER_UPDATE)
"""Messages of a lidar carry the time that the frame's pose belongs to, or that of the update that rendered it
(scanStart: the scan's start).
"""
FRAME_ID_AS_GIVEN = _setting("/tickgraph/frameIdAsGiven", False, product=True)
"""A cloud of points in the WORLD under the frameId of its sensor names the world in its header, or that frameId."""
SCAN_BINS = _setting("/tickgraph/laserScanBinsOfFieldOfView", False, product=True)
"""A LaserScan has one cell for each beam, in the order of firing, and a flat scan one for each emitter of a solid-state
lidar; or both cut the field of view into as many bins as there are beams, ascending.
"""
FLAT_SCAN_NEEDS_2D = _setting("/tickgraph/flatScanNeeds2d", True, product=False)
"""A flat scan of a 3-D lidar is an error, or one warning and outputs at their defaults."""
BOXES_IN_WORLD = _setting("/tickgraph/cameraBoxesInWorld", False, product=True)
"""A camera helper's 3D boxes are in the camera's optical frame, which their header names, or in the world, with the
origins of prims for the centres of their boxes.
"""
INFO_SQUARE_PIXELS = _setting("/tickgraph/cameraInfoSquarePixels", False, product=True)
"""The CameraInfo of a lens with two focal lengths has both, as its image does; or fx twice, with a warning."""
CLOUD_OF_CORNERS = _setting("/tickgraph/cameraCloudOfCorners", False, product=True)
"""A point of a camera helper's depth_pcl lies on the ray that its pixel's lens casts, or on that of a pinhole
through the pixel's top left corner.
"""
MERGE_TRANSFORMS = _setting("/tickgraph/mergeTransforms", True, product=False)
"""Transforms of several nodes with the same topic, quality and stamp are one message, or one for each node."""
ODOMETRY_WORLD_TURN = _setting("/tickgraph/odometryWorldTurn", False, product=True)
"""The angular velocity of odometry is along the axes of the chassis, as nav_msgs/Odometry has it, or along the
world's.
"""
STOP_CLEARS_COMMANDS = _setting("/tickgraph/stopClearsCommands", False, product=True)
"""At stop the command inputs of controllers keep what is written on them, or become 0 (empty, of arrays)."""
NODE_ERRORS_STOP = _setting("/tickgraph/nodeErrorsStop", True, product=False)
"""A compute that raises stops the run, or is logged and the run goes on. Scripts run by `graph exec` always go on."""
SENSOR_NODES_TAKE_BODIES = _setting("/tickgraph/sensorNodesTakeBodies", True, product=False)
"""IsaacReadIMU and IsaacReadContactSensor read any prim on a rigid body, or fail without a sensor's prim."""
ID_MAP_EXTENSION = _setting("/tickgraph/idMapExtension", True, product=False)
"""StableIdMap buffers hold ids without an entry too, for resolve_all, or not."""
RADAR_IGNORES_TICK_RATE = _setting("/tickgraph/radarIgnoresTickRate", False, product=True)
"""Radars render at their tickRate, or in every update."""
RADAR_NEEDS_MOTION_BVH = _setting("/tickgraph/radarNeedsMotionBvh", False, product=True)
"""A radar can be created at any time, or raises a RuntimeError while /renderer/raytracingMotion/enabled is off."""
CAMERA_TONE = _setting("/tickgraph/cameraTone", TONE_LINEAR, product=TONE_ACES)
"""Colours of pictures are proportional to light up to white, or bent by an approximation of the ACES curve."""
ACCEPTED_FINDINGS = _setting("/tickgraph/acceptedFindings", "")
"""Codes, with spaces between, that `graph check --target` does not report for this file: its author knows of them."""

MOTION_BVH = "/renderer/raytracingMotion/enabled"
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


def of_profile(parity: str, values: Mapping[str, Any] | None = None) -> Settings:
    """The settings of a profile: these values over its defaults. Raises UserError for wrong values."""
    settings = Settings(values)
    for path, product in PRODUCT_DEFAULTS.items():
        settings.set_default(path, product if parity == PRODUCT else DEFAULTS[path])
    return settings


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
