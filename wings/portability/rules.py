"""The rules of `graph check --target`: code, what is found, what happens in the product, and what to do instead.

Plain data: the manual's table and the checks read it. A rule is found by every function that `finds` ties to its code.
"""

from __future__ import annotations

from graph.base.records import dataclass

ISAAC, OVRTX = "isaacsim-6.0", "ovrtx"
"""The targets: Isaac Sim 6.0, and ovrtx."""


@dataclass(frozen=True, slots=True)
class Rule:
    """One silent failure or migration.

    what: the finding, for the manual; why: what the product does; fix: what to write instead; targets: the products;
    fixable: whether `--fix` does it.
    """

    code: str
    what: str
    why: str
    fix: str
    targets: tuple[str, ...] = (ISAAC,)
    fixable: bool = False


BOTH = (ISAAC, OVRTX)
_TABLE = (
    # sensors
    Rule(
        "lidar-partial-scan",
        "a lidar whose tickRate differs from its scanRateBaseHz, or with accumulateOutputs off",
        "each frame holds only the arc swept since the last one, without an error",
        "set tickRate to scanRateBaseHz, and accumulateOutputs to true",
        BOTH,
        fixable=True,
    ),
    Rule(
        "sensor-every-frame",
        "a lidar, or a camera with OmniSensorAPI, without a tickRate (0)",
        "it renders in every update, and a lidar never gives a whole scan",
        "author omni:sensor:tickRate: the scan rate of a lidar, the frame rate of a camera",
        BOTH,
    ),
    Rule(
        "sensor-api-missing",
        "a tickRate on a prim without OmniSensorAPI",
        "the rate does not count, and the sensor renders in every update",
        "apply the schema (schemas: [OmniSensorAPI])",
        BOTH,
        fixable=True,
    ),
    Rule(
        "radar-motion-bvh-off",
        "a radar while Motion BVH is off",
        "no frames of it arrive; creating one by a script raises RuntimeError",
        "set /renderer/raytracingMotion/enabled to true, or SimulationApp({'enable_motion_bvh': True})",
        fixable=True,
    ),
    Rule(
        "radar-tick-rate-ignored",
        "a radar with a tickRate",
        "the rate is ignored: the radar renders in every update",
        "gate what it publishes (IsaacSimulationGate)",
    ),
    Rule(
        "fif-race",
        "Motion BVH with a lidar, and a radar whose render product is made in the first 5 updates",
        "the product may crash in the first seconds",
        "make the radar's product after a Countdown of 5",
    ),
    Rule(
        "motion-compensation-off",
        "outputMotionCompensationState COMPENSATED while Motion BVH is off",
        "the points are not compensated",
        "set /renderer/raytracingMotion/enabled to true",
        fixable=True,
    ),
    Rule(
        "aux-level-too-low",
        "a consumer of a quantity above the sensor's auxiliary level (NONE unless authored)",
        "the quantity stays empty, or the process crashes when a script reads it",
        "raise aux_output_level: BASIC for ids of emitter and tick, EXTRA of material and object, FULL for normals",
    ),
    Rule(
        "aux-last-product-wins",
        "rendered lidars and radars with different auxiliary levels",
        "the level acts as if it were global: that of the last attached render product counts for all",
        "give them the same aux_output_level",
    ),
    Rule(
        "aux-output-type-ignored",
        "auxOutputType on a lidar or radar prim",
        "the attribute no longer exists in 6.0 and is ignored",
        "write aux_output_level (_replicator:rendervar:GenericModelOutput:channels)",
    ),
    Rule(
        "report-rate-ignored",
        "reportRateBaseHz on a lidar prim",
        "it is called patternFiringRateHz since 6.0; the old name is ignored",
        "rename it to omni:sensor:Core:patternFiringRateHz",
    ),
    Rule(
        "scan-rate-too-low",
        "scanRateBaseHz below 0.466",
        "a scan is longer than the 32-bit time offsets of its points can count",
        "raise scanRateBaseHz",
        BOTH,
    ),
    Rule(
        "normals-off",
        "hit normals asked for while publishNormals is off",
        "hitNormals are zero or absent",
        "set /app/sensors/nv/lidar/publishNormals to true",
        fixable=True,
    ),
    Rule(
        "stable-ids-off",
        "object ids asked for while stable ids are off",
        "objId and StableIdMap are empty",
        "set /rtx-transient/stableIds/enabled to true",
        fixable=True,
    ),
    Rule(
        "object-id-map-off",
        "object ids in a published cloud without their map",
        "receivers cannot tell which prim an id stands for",
        "set enableObjectIdMap of the helper to true",
    ),
    Rule(
        "output-buffer-on-gpu",
        "/app/sensors/nv/lidar/outputBufferOnGPU or its radar twin switched on",
        "annotators stay empty",
        "leave the setting false",
        fixable=True,
    ),
    Rule(
        "flat-scan-3d",
        "a flat scan of a lidar with beams off the horizontal plane",
        "its outputs stay at their defaults: empty arrays and numRows 1",
        "use a 2D lidar, or its point cloud",
    ),
    Rule(
        "scan-not-spherical",
        "a flat scan or scan buffer of a lidar with elementsCoordsType CARTESIAN",
        "the flat scan stays empty; the scan buffer takes x, y, z for angles and distance",
        "set elementsCoordsType to SPHERICAL, or use OgnIsaacExtractRTXSensorPointCloud",
    ),
    Rule(
        "multi-tick-off",
        "/rtx/hydra/supportMultiTickRate switched off with sensors that have a tickRate",
        "every sensor renders in every update",
        "leave the setting true",
        fixable=True,
    ),
    Rule(
        "ovrtx-vocabulary",
        "omni:sensor:frameRate or partialOutputs, the words of ovrtx",
        "Isaac Sim 6.0 has no such attributes and ignores them",
        "write omni:sensor:tickRate and omni:sensor:Core:accumulateOutputs",
        fixable=True,
    ),
    Rule(
        "isaac-vocabulary",
        "omni:sensor:tickRate or accumulateOutputs, the words of Isaac Sim 6.0",
        "ovrtx has frameRate (n, d for n / d Hz) and partialOutputs, the opposite of accumulateOutputs",
        "write the ovrtx words; both are read here",
        (OVRTX,),
        fixable=True,
    ),
    # graphs
    Rule(
        "frame-skip-deprecated",
        "frameSkipCount of a helper",
        "deprecated: it gates what was rendered for nothing",
        "leave it 0 and lower the sensor's tickRate",
    ),
    Rule(
        "full-scan-deprecated",
        "fullScan of ROS2RtxLidarHelper",
        "deprecated and without effect",
        "leave it out; whole scans come from tickRate = scanRateBaseHz with accumulateOutputs",
        fixable=True,
    ),
    Rule(
        "node-deprecated",
        "a node type that 6.0 deprecates or no longer has",
        "it warns once and may be gone in the next version, or the graph does not load",
        "use its replacement",
    ),
    Rule(
        "type-renamed",
        "a node type by a name from before Isaac Sim 4.5 (omni.isaac.*, ROS 1)",
        "6.0 has no such type; the node does nothing",
        "write the present name",
    ),
    Rule(
        "edit-refused",
        "an edit of a script that names a node type, an input or an output that there is not",
        "Controller.edit raises OmniGraphError; the graph stays as far as the edit had come",
        "correct the name",
    ),
    Rule(
        "attribute-removed",
        "an attribute of an older version of a node, such as swhFrameNumber",
        "6.0 has no such attribute; what it carried is lost",
        "use what replaces it",
    ),
    Rule(
        "timeline-stamp",
        "timeline or loop time as the stamp of a message",
        "the timeline loops at its end and runs apart from the physics clock that stamps sensors",
        "stamp with IsaacReadSimulationTime.simulationTime",
    ),
    Rule(
        "system-time-never-resets",
        "useSystemTime together with resetSimulationTimeOnStop",
        "stamps are wall time of the last physics step, which no stop resets",
        "set resetSimulationTimeOnStop to false",
        fixable=True,
    ),
    Rule(
        "physics-step-stage",
        "OnPhysicsStep in a graph that is not evaluated on demand",
        "it logs an error and never fires",
        "give the graph pipeline_stage: on_demand",
    ),
    Rule(
        "gate-step-zero",
        "IsaacSimulationGate with step 0",
        "it never fires",
        "set step to 1 or more",
    ),
    Rule(
        "joint-indices-zero",
        "IsaacArticulationController with jointIndices [0]",
        "the list counts as empty, and the command goes to all joints",
        "name the joint in jointNames",
    ),
    Rule(
        "fabric-parent-moved",
        "a transform written on a prim above rigid bodies",
        "with Fabric the bodies below stay where physics has them",
        "move the bodies themselves",
    ),
    Rule(
        "edit-not-live",
        "physics or sensor attributes written while playing",
        "they count only after stop and play",
        "write them before play",
    ),
    # clocks
    Rule(
        "physics-slower-than-loop",
        "physics_hz below loop_hz",
        "updates without a physics step give no frames of sensors with a tickRate",
        "raise physics_hz to loop_hz or above",
        BOTH,
    ),
    Rule(
        "catch-up-cap",
        "more physics steps an update than minFrameRate (30 there, unlimited here) allows",
        "physics falls behind without a word: slow motion",
        "set /persistent/simulation/minFrameRate to the loop rate or below",
        fixable=True,
    ),
    Rule(
        "physics-rate-truncated",
        "a physics rate or dt that is not a whole number of steps a second",
        "steps a second are int(1/dt): 1/99 s gives 98 Hz, 0.0167 s gives 59 Hz",
        "give a whole rate, or set_steps_per_second",
    ),
    Rule(
        "rate-limit-without-time-codes",
        "rateLimitFrequency that differs from timeCodesPerSecond in fixed stepping",
        "each update moves the timeline by 1 / timeCodesPerSecond: it runs slow or fast; Play overwrites the limit",
        "set both, or call RenderingManager.set_dt",
    ),
    Rule(
        "rate-limit-stock-frequency",
        "rateLimitEnabled without a rateLimitFrequency",
        "the stock frequency is 120, so get_dt() is 1/120 s",
        "set /app/runLoops/main/rateLimitFrequency",
    ),
    Rule(
        "fast-mode-wall-time",
        "useFastMode (set_play_every_frame) with what reads or waits for wall time",
        "the timeline no longer follows wall time; sleeps and wall-clock loops make an unknown number of updates",
        "use simulation time, or switch useFastMode off",
    ),
    # scripts only
    Rule(
        "next-render-simulation-deprecated",
        "next_render_simulation_async, which waits for one render product",
        "deprecated: it waits for one product, which need not tick in that update",
        "await app_utils.update_app_async(), or poll timestampNs",
    ),
    Rule(
        "annotator-deprecated",
        "a deprecated annotator or writer by name",
        "it warns once and may be gone in the next version",
        "use its replacement",
    ),
    Rule(
        "import-renamed",
        "imports of omni.isaac.*, and of modules that moved",
        "6.0 has no such modules: ModuleNotFoundError",
        "import the present module",
    ),
    Rule(
        "module-unknown",
        "imports from isaacsim.core or isaacsim.core.utils of a module that they do not have",
        "it does not exist: ModuleNotFoundError",
        "correct the name",
    ),
    Rule(
        "module-deprecated",
        "imports of modules that 6.0 deprecates",
        "they still work and may be gone in the next version",
        "import the replacement",
    ),
    Rule(
        "extension-renamed",
        "enabling an extension by its former name",
        "the extension does not exist; enable_extension returns False",
        "enable the present one",
    ),
    Rule(
        "class-deprecated",
        "deprecated classes and Kit commands, such as LidarRtx and IsaacSensorCreateRtxLidar",
        "they warn, and change attributes on their own (accumulateOutputs true, unknown config: a generic prim)",
        "use isaacsim.sensors.experimental.rtx",
    ),
    Rule(
        "gmo-parser-deprecated",
        "get_gmo_data, decode_stable_id_mapping, get_object_ids",
        "deprecated: get_gmo_data(None) returns a class, not an empty object",
        "use the parse functions of isaacsim.sensors.experimental.rtx",
    ),
    Rule(
        "gmo-attribute-missing",
        "azimuth, elevation or distance of a generic model output",
        "there are no such properties: AttributeError",
        "use x (azimuth), y (elevation) in degrees, z (distance)",
    ),
    Rule(
        "aux-level-reset",
        "a sensor class made from the path of a prim that a script gave an auxiliary level",
        "the path is wrapped with defaults: the level becomes NONE",
        "give it the authoring object instead of the path",
    ),
    Rule(
        "object-id-without-entry",
        "a stable-id map subscripted with an object id",
        "ids of sub-meshes have no entry: KeyError",
        "use .get(id, '<unknown>')",
    ),
    Rule(
        "prims-added-while-playing",
        "prims made after play",
        "physics and sensors do not see them before stop and play; here they are refused",
        "make them before play",
    ),
    Rule(
        "physics-dt-while-playing",
        "set_physics_dt after play",
        "RuntimeError",
        "call it before play, or SimulationManager.setup_simulation",
    ),
    Rule(
        "min-frame-rate-changed",
        "SimulationContext.set_simulation_dt",
        "deprecated, and it sets minFrameRate so that at most int(rendering_dt / physics_dt) steps run an update",
        "use SimulationManager.setup_simulation and RenderingManager.set_dt",
    ),
    Rule(
        "manual-mode-lag",
        "the setting manualModeEnabled written while the app runs",
        "it reaches dt only in the second update after",
        "call set_manual_mode of the loop runner",
    ),
    Rule(
        "callback-arguments-swapped",
        "register_callback with its first two arguments in the other manager's order",
        "RenderingManager takes (event, callback=...), SimulationManager (callback, event): ValueError",
        "swap them",
    ),
    Rule(
        "callback-dropped",
        "a bound method of a temporary object as a callback",
        "managers hold bound methods weakly: it is never called",
        "keep the object in a variable",
    ),
    Rule(
        "default-callbacks-off",
        "enable_default_callbacks with some of its four switches",
        "the switches left out are turned off",
        "give all four",
    ),
    Rule(
        "assets-root-raises",
        "get_assets_root_path() compared with None",
        "6.0 raises RuntimeError and never returns None",
        "catch RuntimeError, or give skip_check=True",
    ),
    Rule(
        "open-stage-always-true",
        "the truth of open_stage of isaacsim.core.experimental.utils.stage",
        "it returns (opened, stage), which is always true",
        "take its first item",
    ),
    Rule(
        "import-before-app",
        "imports of omni or isaacsim modules before SimulationApp is made",
        "the modules do not exist yet: ModuleNotFoundError",
        "import them after SimulationApp(...)",
    ),
    Rule(
        "code-after-close",
        "statements after close() of the SimulationApp",
        "close() ends the process: they never run",
        "put them before close()",
    ),
    Rule(
        "asyncio-run",
        "asyncio.run",
        "a loop runs already in Kit: RuntimeError",
        "use asyncio.ensure_future, or run_coroutine of the SimulationApp",
    ),
)  # fmt: skip

RULES = {rule.code: rule for rule in _TABLE}
