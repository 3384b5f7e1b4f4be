"""Every annotator of a lidar, used from Python as in Replicator: `python graphs/annotators.py [FOLDER]`.

Prints what each hands out of the first frame; with a FOLDER the clouds are drawn into it as PNG files, too.
"""

from __future__ import annotations

import sys

import sensors.replicator as rep
from graph.sim import App
from sensors import Lidar, parse_generic_model_output_data, parse_object_ids, parse_stable_id_map_data

SETTINGS = {
    "/rtx-transient/stableIds/enabled": True,  # object ids
    "/app/sensors/nv/lidar/publishNormals": True,  # hit normals
}


def world() -> App:
    """A planar lidar of aux level FULL between a wall and a barrel."""
    from pxr import Gf, UsdGeom

    app = App(physics_hz=240, loop_hz=60, settings=SETTINGS)
    wall = UsdGeom.Cube.Define(app.stage, "/World/Wall")
    barrel = UsdGeom.Cylinder.Define(app.stage, "/World/Barrel")
    UsdGeom.XformCommonAPI(wall).SetTranslate(Gf.Vec3d(6, 0, 0))
    UsdGeom.XformCommonAPI(barrel).SetTranslate(Gf.Vec3d(0, 4, 0))
    Lidar.create("/World/Lidar", config="Example_Rotary_2D", aux_output_level="FULL", app=app)
    return app


def main(folder: str | None = None) -> None:
    """Attaches everything, runs to the first frame and prints."""
    with world() as app:
        product = rep.create.render_product("/World/Lidar", (1024, 1024))

        output = rep.AnnotatorRegistry.get_annotator("GenericModelOutput").attach(product)
        ids = rep.AnnotatorRegistry.get_annotator("StableIdMap").attach(product)
        classes = rep.AnnotatorRegistry.get_annotator("SemanticClasses").attach(product)
        cloud = rep.AnnotatorRegistry.get_annotator("IsaacExtractRTXSensorPointCloud").attach(product)

        # Deprecated, each with one warning that says what to use. Options come before attach.
        old_cloud = rep.AnnotatorRegistry.get_annotator("IsaacExtractRTXSensorPointCloudNoAccumulator").attach(product)
        flat = rep.AnnotatorRegistry.get_annotator("IsaacComputeRTXLidarFlatScan").attach(product)
        buffer = rep.AnnotatorRegistry.get_annotator("IsaacCreateRTXLidarScanBuffer")
        buffer.initialize(outputTimestamp=True, outputObjectId=True, outputHitNormal=True)
        buffer.attach([product.path])

        if folder is not None:
            writer = rep.writers.get("RtxSensorDebugDrawPointCloud")
            writer.initialize(output_dir=folder, size=0.05, view="top")
            writer.attach([product])

        app.play()
        app.update(steps=6)  # 0.1 s: one turn

        gmo = parse_generic_model_output_data(output.get_data())
        paths = parse_stable_id_map_data(ids.get_data(), resolve_all=True)
        hit = sorted({paths[number] for number in parse_object_ids(gmo.objId)})
        scan = flat.get_data()
        print(f"GenericModelOutput: {gmo.numElements} returns at {gmo.timestampNs} ns, aux {gmo.auxType.name}")
        print(f"StableIdMap: they hit {', '.join(hit)}")
        print(f"SemanticClasses: {classes.get_data()['info']['idToLabels']}")
        print(f"IsaacExtractRTXSensorPointCloud: {sorted(cloud.get_data())}")
        print(f"IsaacExtractRTXSensorPointCloudNoAccumulator: {len(old_cloud.get_data()['data'])} points")
        nearest = min(depth for depth in scan["linearDepthData"] if depth > 0)
        print(f"IsaacComputeRTXLidarFlatScan: {scan['numCols']} columns, nearest {nearest:.3f} m")
        print(f"IsaacCreateRTXLidarScanBuffer: {sorted(buffer.get_data())}")


if __name__ == "__main__":
    main(*sys.argv[1:2])
