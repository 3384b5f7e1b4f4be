"""Services between nodes: a client asks, a server answers."""

import pytest

from graph import ComputeError
from graph.testing import run_node

ADD = {"messagePackage": "example_interfaces", "messageName": "AddTwoInts"}
GRAPH = """\
nodes:
  tick: OnPlaybackTick
  client:
    type: ROS2ServiceClient
    inputs: {messagePackage: example_interfaces, messageName: AddTwoInts, serviceName: /add, "Request:a": 11}
  server:
    type: ROS2ServiceServerRequest
    inputs: {messagePackage: example_interfaces, messageName: AddTwoInts, serviceName: add}
  answer: {type: ROS2ServiceServerResponse, inputs: {messagePackage: example_interfaces, messageName: AddTwoInts}}
  ten: {type: ConstantInt64, inputs: {value: 10}}
  sum: {type: Add}
  got: {type: Counter}
  see: {type: ToString}
connections:
  - ten.value -> client.Request:b
  - tick.tick -> [client.execIn, server.execIn]
  - server.onReceived -> answer.onReceived
  - server.serverHandle -> answer.serverHandle
  - server.Request:a -> sum.a
  - server.Request:b -> sum.b
  - sum.sum -> answer.Response:sum
  - client.execOut -> got.execIn
  - client.Response:sum -> see.value
"""


def test_a_request_goes_to_the_server_and_its_answer_comes_back(run_file):
    app = run_file(GRAPH, 1)
    # Update 0: the client finds no server yet (it comes later in the same update).
    assert app.value("server", "Request:a") == 0
    app.update()
    # Update 1: asked and answered, in this order.
    assert [app.value("server", f"Request:{name}") for name in "ab"] == [11, 10]
    assert app.value("answer", "inputs:Response:sum") == 21
    assert app.value("client", "Response:sum") == 0
    app.update()
    # Update 2: the answer is taken, the next question asked.
    assert app.value("client", "Response:sum") == 21
    assert app.value("got", "count") == 1
    app.update()
    assert app.value("got", "count") == 2


def test_a_stop_closes_the_service_and_a_new_play_opens_it_again(run_file):
    app = run_file(GRAPH, 5)
    app.stop()
    assert app.bus.services.call("/add", "example_interfaces/srv/AddTwoInts", None) is None
    app.play()
    app.update(3)
    assert app.value("client", "Response:sum") == 21


def client(app, updates=4, **inputs):
    return run_node(
        "ROS2ServiceClient",
        inputs={**ADD, "Request:a": 1, **inputs},
        outputs=["Response:sum"],
        pulses={"execIn": range(updates)}, updates=updates, app=app,
    )  # fmt: skip


def test_a_client_waits_for_its_answer_and_asks_one_thing_at_a_time(world):
    from graph.sim.messages.ros_types import message_type

    app = world()
    server = app.bus.services.serve("/service_name", "example_interfaces/srv/AddTwoInts")
    response = message_type("example_interfaces/srv/AddTwoInts_Response")
    asked = []

    def serve():
        asked.append(len(server.waiting))
        if app.update_index == 2:
            assert server.take().a == 1
            server.answer(response(5))

    app.on("simulation_graphs", serve, order=-1)
    trace = client(app, 4)
    assert asked == [0, 1, 1, 1]
    assert trace.fired("execOut") == [2]
    assert trace.values("Response:sum") == [0, 0, 5, 5]


def test_without_a_server_a_client_does_nothing(world):
    assert client(world()).fired("execOut") == []


def test_a_response_without_open_request_sends_nothing(world):
    trace = run_node("ROS2ServiceServerResponse", inputs=ADD, pulses={"onReceived": [0]}, app=world())
    assert trace.fired("execOut") == []


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"serviceName": " "}, "serviceName is empty"),
        ({"messagePackage": "std_msgs", "messageName": "Bool", "messageSubfolder": "msg"}, 'messageSubfolder is "srv"'),
        ({"messageName": ""}, "set messagePackage and messageName"),
    ],
)
def test_a_server_needs_a_name_and_a_service_type(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        run_node("ROS2ServiceServerRequest", inputs={**ADD, **inputs}, pulses={"execIn": [0]}, app=world())


def test_two_servers_of_one_service_stop_the_run(world):
    app = world()
    app.bus.services.serve("/service_name", "example_interfaces/srv/AddTwoInts", "/G/other")
    with pytest.raises(Exception, match="service /service_name has a server already: /G/other"):
        run_node("ROS2ServiceServerRequest", inputs=ADD, pulses={"execIn": [0]}, app=app)
