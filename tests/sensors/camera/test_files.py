"""Cameras in graph files: what the commands say of them."""

import json

import pytest

from graph.cli.main import main
from tests.support.places import ROOT

EXAMPLE = ROOT / "graphs" / "camera.yaml"


def test_inspect_shows_every_channel_and_what_the_pixels_show(capsys):
    assert main(["inspect", str(EXAMPLE), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["sensor"], told["update"], told["header"]["timestampNs"]) == ("/World/Camera", 3, 66_666_667)
    channels = told["channels"]
    assert (channels["rgb"]["dtype"], channels["rgb"]["shape"]) == ("uint8", [240, 320, 3])
    assert channels["distance_to_camera"]["min"] > 0  # infinite values do not count
    box = channels["bounding_box_2d_tight"]
    assert box["dtype"] == "record"
    assert set(box["first"][0]) == {"instance", "x_min", "y_min", "x_max", "y_max", "occlusionRatio"}
    assert set(told["hits"]) == {
        *("/World/Hall", "/World/Ground", "/World/Crate", "/World/Barrel", "/World/Ball", "(nothing)")
    }
    assert sum(told["hits"].values()) == 320 * 240


@pytest.mark.parametrize(
    ("prims", "size"),
    [
        ("{type: Camera}", (1280, 720)),
        ("{type: Camera, config: Femto Mega, variant: narrow}", (1280, 720)),
        ("{type: Camera, config: Hawk, variant: left}", (1280, 720)),
        ("{type: Camera, config: D455, variant: depth}", (1280, 720)),
        ("{type: Camera, config: OAK4-D, variant: left}", (1280, 800)),
    ],
)
def test_inspect_of_a_camera_without_a_graph_takes_the_size_of_its_configuration_or_the_usual_one(
    tmp_path, prims, size
):
    """Of cameras without a stereo measurement nothing keeps a size."""
    from graph.cli.inspect import product_size
    from graph.session.open import open_session

    path = tmp_path / "camera.yaml"
    path.write_text(f"tickgraph: 1\nscene:\n  prims:\n    /World/Camera: {prims}\n")
    with open_session(path).app as app:
        assert product_size(app, "/World/Camera") == size


def test_explain_shows_the_lens_the_schedule_and_who_listens(capsys):
    assert main(["explain", str(EXAMPLE)]) == 0
    out = capsys.readouterr().out
    shown = out[out.index("/World/Camera (Camera)") :].split("\n\n")[0]
    assert "tick 15 Hz" in shown
    assert "pinhole, focal length 18, aperture 20.955, shows 0.05 to 100 m" in shown
    assert "30 in 2 s" in shown
    assert "/World/ActionGraph/depth: distance_to_image_plane" in shown


def test_too_many_pixels_are_told_at_their_node(tmp_path, capsys):
    file = tmp_path / "big.yaml"
    file.write_text(EXAMPLE.read_text(encoding="utf8").replace("width: 320", "width: 100000"), encoding="utf8")
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert "big.yaml:41:85: /World/ActionGraph/product.inputs:width" in error
    assert "100,000 x 240 has 24,000,000 pixels; the limit is 10,000,000 rays; raise it with --limit" in error


def test_a_camera_that_cannot_be_is_a_problem_of_the_file(tmp_path, capsys):
    file = tmp_path / "bad.yaml"
    file.write_text(EXAMPLE.read_text(encoding="utf8").replace("focalLength: 18.0", "focalLength: 0"), encoding="utf8")
    assert main(["check", str(file)]) == 2
    assert "/World/Camera.focalLength is 0.0; give a number above 0" in capsys.readouterr().err
