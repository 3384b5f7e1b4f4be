import logging

import pytest

from graph.testing import run_node


@pytest.mark.parametrize(
    ("kind", "inputs", "level", "text"),
    [
        ("LogMessage", {"message": "hello"}, logging.INFO, "[omni.graph.nodes_core.plugin] hello"),
        ("LogMessage", {"message": "hm", "logLevel": "Warn", "channel": "arm"}, logging.WARNING, "[arm] hm"),
        ("PrintText", {"text": "100 % {}"}, logging.INFO, "100 % {}"),
        ("PrintText", {"text": "bad", "logLevel": "Error"}, logging.ERROR, "bad"),
    ],
)
def test_a_message_goes_to_the_logger_and_the_flow_goes_on(caplog, kind, inputs, level, text):
    with caplog.at_level(logging.DEBUG, "tickgraph"):
        trace = run_node(kind, inputs=inputs, pulses={"execIn": [0]}, updates=1)
    assert [(one.levelno, one.getMessage()) for one in caplog.records] == [(level, text)]
    assert trace.fired("execOut") == [0]
