from graph.testing import run_node

NODE = "omni.replicator.core.OgnGetPrimAtPath"


def test_prims_of_the_stage_become_a_target(stage, world):
    from pxr import UsdGeom

    for path in ("/World/A", "/World/B"):
        UsdGeom.Xform.Define(stage, path)
    trace = run_node(
        NODE, inputs={"paths": ["/World/B", "/World/A"]}, pulses={"execIn": [0, 2]}, updates=3, app=world()
    )
    assert trace.fired("execOut") == [0, 2]
    assert trace.value("prims") == ["/World/B", "/World/A"]


def test_with_a_missing_prim_nothing_follows(stage, world):
    from pxr import UsdGeom

    UsdGeom.Xform.Define(stage, "/World/A")
    app = world()
    trace = run_node(NODE, inputs={"paths": ["/World/A", "/World/Gone"]}, pulses={"execIn": [0]}, updates=1, app=app)
    assert trace.fired("execOut") == []
    assert trace.value("prims") == []
    [warning] = trace.warnings
    assert (warning.code, "/World/Gone" in warning.message) == ("prim-missing", True)


LATE = """\
tickgraph: 1
scene: {prims: {/World/Box: {type: Cube}}}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      prim: {type: omni.replicator.core.OgnGetPrimAtPath, inputs: {paths: [/World/Box]}}
      tf: ROS2PublishTransformTree
    connections:
      - tick.tick -> [tf.execIn, prim.execIn]
      - prim.prims -> tf.targetPrims
      - time.simulationTime -> tf.timeStamp
"""


def test_a_publisher_waits_for_the_node_that_gives_it_its_prims(tmp_path, capsys):
    """The publisher is wired first, so that it has no prims in the first update: 2 messages in 3 updates."""
    import json

    from graph.cli.main import main

    path = tmp_path / "a.yaml"
    path.write_text(LATE)
    assert main(["run", str(path), "--updates", "3", "--json"]) == 0
    told = capsys.readouterr()
    assert [one["messages"] for one in json.loads(told.out)["topics"].values()] == [2]
    assert "input-not-set: /G/tf: nothing to publish; set targetPrims" in told.err
    assert main(["run", str(path), "--updates", "3", "--on-error", "stop"]) == 1
