"""Profiles: differences between the Isaac Sim product and its documentation, each as one setting.

`documented` follows the documentation and is what `graph.sim.settings.DEFAULTS` holds; `isaacsim-6.0.1` behaves as the
product does. A profile only changes defaults: values that a user sets, by file, command line or API, are preferred.
"""

from __future__ import annotations

from typing import Any

from graph.base.records import dataclass
from graph.sim import settings as keys
from graph.sim.settings import DEFAULTS, Settings

DOCUMENTED = "documented"
PRODUCT = "isaacsim-6.0.1"
PARITIES = (DOCUMENTED, PRODUCT)


@dataclass(frozen=True, slots=True)
class Difference:
    """One setting whose default depends on the profile; `doc` describes its two values, the documented one first."""

    setting: str
    product: Any
    doc: str

    @property
    def documented(self) -> Any:
        """The value in the profile `documented`."""
        return DEFAULTS[self.setting]

    def of(self, parity: str) -> Any:
        """The value in a profile."""
        return self.product if parity == PRODUCT else self.documented


DIFFERENCES: tuple[Difference, ...] = (
    Difference(keys.WARM_UP_STEPS, 2, "physics steps that a play from stopped runs before the first update"),
    Difference(keys.MIN_FRAME_RATE, 30, "catch-up cap: max(1, sps // this) steps an update; 0: no cap"),
    Difference(
        keys.TRUNCATE_STEPS, True, "steps per second of a dt: exactly 1/dt, or int(1/dt), which loses a step for 1/93"
    ),
    Difference(
        keys.SAMPLE_SUBSTEPS,
        True,
        "time samples: one an update with its exact time as key; or one a substep, keys in whole microseconds, and "
        "the simulation time at t is t itself",
    ),
    Difference(
        keys.SET_DT_RATE_LIMIT,
        False,
        "set_dt sets rateLimitFrequency and targetFramerate always, or only while rateLimitEnabled",
    ),
    Difference(keys.RATE_LIMIT_FREQUENCY, 120, "updates a second of wall time, unless set"),
    Difference(
        keys.REWRITE_RATE_LIMIT, True, "Play in fixed stepping sets rateLimitFrequency to N x timeCodesPerSecond"
    ),
    Difference(
        keys.AUTOTRIGGER_IDLE,
        True,
        "in an update without a physics step nothing renders, or autotrigger sensors (tickRate 0) do",
    ),
    Difference(keys.BARE_LIDAR_TICK_RATE, 10, "tickRate [Hz] of a lidar prim that authors none"),
    Difference(
        keys.FRAMES_LATER,
        True,
        "frames arrive in the update that renders them, or at the begin of the next one; the latter unless "
        "checkForHydraRenderComplete comes after rendering, as in the experience zero_delay",
    ),
    Difference(
        keys.FULL_SCAN_WARNS, True, "the value of the lidar helper's fullScan that gives the deprecation warning"
    ),
    Difference(keys.SCAN_EMPTY_MINUS_ONE, True, "an empty beam of a LaserScan is +inf, or -1"),
    Difference(
        keys.SCAN_END_BEYOND, True, "angle_max of a LaserScan is the last beam's angle, or one increment beyond it"
    ),
    Difference(
        keys.LIDAR_HEADER,
        keys.HEADER_UPDATE,
        "messages of a lidar carry the time that the frame's pose belongs to, or that of the update that rendered it "
        "(scanStart: the scan's start)",
    ),
    Difference(
        keys.FRAME_ID_AS_GIVEN,
        True,
        "a cloud of points in the WORLD under the frameId of its sensor names the world in its header, or that frameId",
    ),
    Difference(
        keys.SCAN_BINS,
        True,
        "a LaserScan has one cell for each beam, in the order of firing, and a flat scan one for each emitter of a "
        "solid-state lidar; or both cut the field of view into as many bins as there are beams, ascending",
    ),
    Difference(
        keys.FLAT_SCAN_NEEDS_2D,
        False,
        "a flat scan of a 3-D lidar is an error, or one warning and outputs at their defaults",
    ),
    Difference(
        keys.BOXES_IN_WORLD,
        True,
        "a camera helper's 3D boxes are in the camera's optical frame, which their header names, or in the world, with "
        "the origins of prims for the centres of their boxes",
    ),
    Difference(
        keys.INFO_SQUARE_PIXELS,
        True,
        "the CameraInfo of a lens with two focal lengths has both, as its image does; or fx twice, with a warning",
    ),
    Difference(
        keys.CLOUD_OF_CORNERS,
        True,
        "a point of a camera helper's depth_pcl lies on the ray that its pixel's lens casts, or on that of a pinhole "
        "through the pixel's top left corner",
    ),
    Difference(
        keys.MERGE_TRANSFORMS,
        False,
        "transforms of several nodes with the same topic, quality and stamp are one message, or one for each node",
    ),
    Difference(
        keys.ODOMETRY_WORLD_TURN,
        True,
        "the angular velocity of odometry is along the axes of the chassis, as nav_msgs/Odometry has it, or along the "
        "world's",
    ),
    Difference(
        keys.STOP_CLEARS_COMMANDS,
        True,
        "at stop the command inputs of controllers keep what is written on them, or become 0 (empty, of arrays)",
    ),
    Difference(keys.NODE_ERRORS_STOP, False, "a compute that raises stops the run, or is logged and the run goes on"),
    Difference(keys.RADAR_IGNORES_TICK_RATE, True, "radars render at their tickRate, or in every update"),
    Difference(
        keys.RADAR_NEEDS_MOTION_BVH,
        True,
        "a radar can be created at any time, or raises a RuntimeError while /renderer/raytracingMotion/enabled is off",
    ),
    Difference(
        keys.CAMERA_TONE,
        keys.TONE_ACES,
        "colours of pictures are proportional to light up to white, or bent by an approximation of the ACES curve",
    ),
    Difference(
        keys.ID_MAP_EXTENSION,
        False,
        "StableIdMap buffers hold ids without an entry too, for resolve_all, or not",
    ),
)
"""All differences, in the order of an update.

Interrupting sleeping latent nodes is not one: both profiles ignore the trigger, and
`/ext/omni.graph.action/disableInterrupts = false` lets it interrupt.
"""


def apply_profile(settings: Settings, parity: str) -> None:
    """Sets the profile's defaults; values that the user has set stay."""
    for difference in DIFFERENCES:
        settings.set_default(difference.setting, difference.of(parity))
