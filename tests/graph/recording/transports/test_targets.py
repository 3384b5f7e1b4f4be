"""What --live understands, and what it refuses in one line before anything is written."""

import socket
import sys

import pytest

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.cli.main import main
from graph.recording.transports import targets
from graph.recording.transports.targets import Target, read_targets
from tests.support.without_wing import needs_wing

pytestmark = needs_wing("transports")


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    monkeypatch.setattr(targets.importlib.util, "find_spec", lambda name: object())
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


@pytest.mark.parametrize(
    ("text", "host", "port"),
    [
        ("foxglove", "127.0.0.1", 8765),
        ("foxglove:9000", "127.0.0.1", 9000),
        ("foxglove:0.0.0.0", "0.0.0.0", 8765),
        ("foxglove:robot.local:9000", "robot.local", 9000),
        ("foxglove:[::1]:9000", "::1", 9000),
        ("foxglove:[::1]", "::1", 8765),
        ("rerun", "127.0.0.1", 9876),
        ("zenoh", "127.0.0.1", 7447),
        ("zenoh:10.0.0.2:7448", "10.0.0.2", 7448),
        ("dds", "127.0.0.1", 0),
        ("dds:eth0", "eth0", 0),
        ("dds:192.168.1.5", "192.168.1.5", 0),
    ],
)
def test_a_target_is_a_name_a_host_and_a_port_on_this_machine_unless_it_says_otherwise(text, host, port):
    name = text.partition(":")[0]
    assert read_targets([text]) == [Target(name, host, port)]


def test_ros_transports_use_the_domain_of_ros(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    assert [target.domain for target in read_targets(["dds", "zenoh", "foxglove"])] == [42, 42, 0]


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        (["foxglov"], "there is no transport 'foxglov'; did you mean \"foxglove\"?"),
        ([""], "there is no transport ''; there are dds, foxglove, rerun, zenoh"),
        (["foxglove:99999"], "'99999' is not a port"),
        (["foxglove:0"], "'0' is not a port"),
        (["foxglove:localhost:x"], "'x' is not a port"),
        (["foxglove:a b"], "'a b' is not an address"),
        (["dds:eth0:7400"], "'eth0:7400' is not an address; write dds:HOST"),
        (['dds:"/><x'], "is not an address"),
        (["dds", "dds:eth0"], "dds is given twice"),
    ],
)
def test_a_wrong_target_is_refused_in_one_line(texts, said):
    with pytest.raises(UserError) as error:
        read_targets(texts)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("domain", ["-1", "233", "x"])
def test_a_domain_that_has_no_ports_is_refused(monkeypatch, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with pytest.raises(UserError, match="ROS_DOMAIN_ID"):
        read_targets(["dds"])


@pytest.mark.parametrize("name", ["foxglove", "rerun", "dds", "zenoh"])
def test_without_the_extra_the_line_says_how_to_install_it_and_nothing_is_written(name, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(targets.importlib.util, "find_spec", lambda name: None)
    out = tmp_path / "out"
    assert main(["run", "graphs/quickstart.yaml", "--live", name, "--out", str(out)]) == 2
    assert install_command(name) in capsys.readouterr().err
    assert not out.exists()


def test_a_port_in_use_is_one_line_and_nothing_is_written(tmp_path, capsys):
    pytest.importorskip("foxglove")
    out = tmp_path / "out"
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        code = main(["run", "graphs/quickstart.yaml", "--live", f"foxglove:{port}", "--out", str(out)])
    said = capsys.readouterr().err
    assert code == 2
    assert said.count("\n") == 1
    assert "Address already in use" in said or sys.platform != "linux"
    assert not out.exists()
