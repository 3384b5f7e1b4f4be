import re

import pytest

from graph.files import loads
from graph.files.connections import PATTERN, parse


def ends(text):
    return [(link.source, link.target) for link in parse(text)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a.x -> b.y", [("a.x", "b.y")]),
        ("  a.x->b.y ", [("a.x", "b.y")]),
        ("tick.outputs:tick -> wait.inputs:execIn", [("tick.outputs:tick", "wait.inputs:execIn")]),
        ("/World/G.n.outputs:x -> b.y", [("/World/G.n.outputs:x", "b.y")]),
        ("/World/G/n.outputs:x -> /World/H/m.inputs:y", [("/World/G/n.outputs:x", "/World/H/m.inputs:y")]),
        ("a.x -> [b.y, c.z]", [("a.x", "b.y"), ("a.x", "c.z")]),
        ("a.x->[ c.z ,b.y,d.w,]", [("a.x", "c.z"), ("a.x", "b.y"), ("a.x", "d.w")]),
        ("a.x -> [b.y]", [("a.x", "b.y")]),
    ],
)
def test_every_form_of_a_connection(text, expected):
    assert ends(text) == expected
    assert re.search(PATTERN, text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a.x b.y", 'connection "a.x b.y" has no arrow; '),
        ("a.x -> b.y -> c.z", 'connection "a.x -> b.y -> c.z" has 2 arrows; '),
        ("-> b.y", 'connection "-> b.y" has only one end; '),
        ("a.x ->", 'connection "a.x ->" has only one end; '),
        ("a.x -> []", 'connection "a.x -> []" has no target; '),
        ("a.x -> [b.y,,c.z]", 'connection "a.x -> [b.y,,c.z]" has only one end; '),
        ("a.x -> [b.y", 'connection "a.x -> [b.y" opens "[" without closing it; '),
        ("[a.x, b.y] -> c.z", 'connection end "[a.x, b.y]" is not of the form node.attribute; '),
        ("a.x -> wait", 'connection end "wait" names no attribute; write "wait.attribute"'),
        ("a. -> b.y", 'connection end "a." is not of the form node.attribute; '),
        (".x -> b.y", 'connection end ".x" is not of the form node.attribute; '),
        ("a b.x -> b.y", 'connection end "a b.x" is not of the form node.attribute; '),
        ("", 'connection "" has no arrow; '),
    ],
)
def test_what_is_wrong_with_a_connection_is_reported(text, reason):
    with pytest.raises(ValueError, match="^" + re.escape(reason)):
        parse(text)
    assert not re.search(PATTERN, text)


def marks(text):
    [graph] = loads(text).graphs
    return [(c.target, c.mark.line, c.mark.column) for c in graph.connections]


def test_each_target_of_a_fan_out_has_its_own_place():
    text = "tickgraph: 1\ngraphs:\n  /G:\n    connections:\n      - a.x -> b.y\n      - a.x -> [b.y,  c.z]\n"
    assert marks(text) == [("b.y", 5, 9), ("b.y", 6, 17), ("c.z", 6, 23)]


def test_quoted_connections_have_places_too():
    text = 'tickgraph: 1\ngraphs: {/G: {connections: ["a.x -> [b.y, c.z]"]}}\n'
    assert marks(text) == [("b.y", 2, 38), ("c.z", 2, 43)]


def test_an_escaped_connection_is_placed_at_its_start():
    text = 'tickgraph: 1\ngraphs: {/G: {connections: ["a.x \\x2d> [b.y, c.z]"]}}\n'
    assert marks(text) == [("b.y", 2, 29), ("c.z", 2, 29)]
