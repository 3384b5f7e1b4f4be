import json

GOOD = """\
tickgraph: 1
scene: {prims: {/World/Ball: {type: Sphere, radius: 0.5}}}
graphs:
  /World/Graph:
    nodes: {tick: OnPlaybackTick, wait: {type: Countdown, inputs: {duration: 3}}}
    connections: [tick.tick -> wait.execIn]
"""
BAD = """\
tickgraph: 1
clock: {loop_hz: 0}
scene: {prims: {/World/Ball: {type: Sphere, radios: 0.5}}}
graphs:
  /World/Graph:
    nodes: {tick: OnPlaybackTick, wait: {type: Countdwon}}
    connections: [tick.tick -> wait.execIn]
"""


def test_a_good_file_is_one_line_with_its_counts(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    result = graph("check", "good.yaml")
    assert (result.code, result.err) == (0, "")
    assert result.out == "good.yaml: ok, 1 graph, 2 nodes, 1 connection, 1 prim\n"


def test_problems_of_text_graphs_and_scene_come_together_in_the_order_of_the_file(folder, graph):
    (folder / "bad.yaml").write_text(BAD)
    result = graph("check", "bad.yaml")
    assert (result.code, result.out) == (2, "")
    lines = result.err.splitlines()
    assert [line.split(": ")[0] for line in lines] == ["bad.yaml:2:18", "bad.yaml:3:45", "bad.yaml:6:35"]
    assert 'did you mean "radius"?' in lines[1]
    assert 'did you mean "Countdown"?' in lines[2]


def test_every_file_is_checked_and_one_bad_one_decides_the_exit_code(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    (folder / "bad.yaml").write_text("tickgraph: 1\nx: 1\n")
    result = graph("check", "bad.yaml", "good.yaml", "none.yaml")
    assert result.code == 2
    assert result.out == "good.yaml: ok, 1 graph, 2 nodes, 1 connection, 1 prim\n"
    assert [line.partition(" ")[0] for line in result.err.splitlines()] == ["bad.yaml:2:1:", "graph:"]
    assert "none.yaml: no such file" in result.err


def test_json_tells_all_files_and_every_place(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    (folder / "bad.yaml").write_text("tickgraph: 1\nrecrod: {}\n")
    result = graph("check", "good.yaml", "bad.yaml", "none.yaml", "--json")
    assert result.code == 2
    good, bad, none = json.loads(result.out)["files"]
    assert good == {
        "file": "good.yaml",
        "ok": True,
        "graphs": 1,
        "nodes": 2,
        "connections": 1,
        "prims": 1,
        "problems": [],
        "warnings": [],
    }
    assert bad["ok"] is False
    assert bad["problems"] == [
        {"message": 'unknown key "recrod"; did you mean "record"?', "file": "bad.yaml", "line": 2, "column": 1}
    ]
    assert none["problems"][0]["line"] is None


def test_a_check_writes_nothing(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    graph("check", "good.yaml")
    assert [path.name for path in folder.iterdir()] == ["good.yaml"]


def test_allow_widens_what_a_file_may_name(folder, graph):
    (folder / "sub").mkdir()
    (folder / "box.usda").write_text('#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\ndef Cube "Box" {}\n')
    (folder / "sub" / "a.yaml").write_text("tickgraph: 1\nscene: {usd: ../box.usda}\n")
    refused = graph("check", "sub/a.yaml")
    assert refused.code == 2
    assert "allow its folder with --allow" in refused.err
    assert graph("check", "sub/a.yaml", "--allow", ".").code == 0


def test_options_of_the_file_and_the_command_line_are_checked(folder, graph):
    (folder / "a.yaml").write_text("tickgraph: 1\nfidelity: {lidar.moton: frozen}\n")
    result = graph("check", "a.yaml")
    assert result.code == 2
    assert result.err.startswith("a.yaml:2:12: ")
    assert 'did you mean "lidar.motion"?' in result.err
    (folder / "b.yaml").write_text("tickgraph: 1\n")
    assert graph("check", "b.yaml", "--/rtx/hydra/supportMultiTickRate=true").code == 0
    assert graph("check", "b.yaml", "--/app/runLoops/main/rateLimitFrequency=-5").code == 2


FLAT = """\
tickgraph: 1
scene: {{prims: {{/World/Lidar: {{type: OmniLidar, config: {config}}}}}}}
clock: {{parity: {parity}}}
graphs:
  /World/Make:
    nodes: {{tick: OnPlaybackTick, product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Lidar}}}}}}
    connections: [tick.tick -> product.execIn]
  /World/Frames:
    pipeline_stage: post_render
    nodes:
      flat: IsaacComputeRTXLidarFlatScan
    connections: [/World/Make/product.outputs:renderProductPath -> flat.renderProductPath]
"""


def test_a_flat_scan_of_a_3d_lidar_is_told_before_anything_runs(folder, graph):
    (folder / "tall.yaml").write_text(FLAT.format(config="XT32", parity="documented"))
    (folder / "flat.yaml").write_text(FLAT.format(config="Example_Rotary_2D", parity="documented"))
    (folder / "product.yaml").write_text(FLAT.format(config="XT32", parity="isaacsim-6.0.1"))

    result = graph("run", "tall.yaml", "--out", "out")

    assert result.code == 2
    assert result.err.splitlines() == [
        "tall.yaml:11:7: /World/Frames/flat: /World/Lidar: a flat scan needs a 2D lidar, but emitter 0 points 15 deg "
        "up; use a lidar with all elevations 0"
    ]
    assert not (folder / "out").exists()
    assert graph("check", "flat.yaml").code == 0
    assert graph("check", "product.yaml").code == 0  # logs it at run time, and goes on


def test_a_prim_where_a_render_product_belongs_is_told(folder, graph):
    text = FLAT.format(config="Example_Rotary_2D", parity="documented")
    text = text.replace("flat: IsaacCompute", "flat: {type: IsaacCompute").replace(
        "FlatScan\n", "FlatScan, inputs: {renderProductPath: /World/Lidar}}\n"
    )
    (folder / "prim.yaml").write_text(text[: text.rindex("    connections")])

    result = graph("check", "prim.yaml")

    assert result.code == 2
    assert result.err == (
        "prim.yaml:11:59: /World/Frames/flat.inputs:renderProductPath: /World/Lidar is a prim, not a render product; "
        "connect it to IsaacCreateRenderProduct with cameraPrim /World/Lidar\n"
    )
