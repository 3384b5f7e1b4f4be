"""Large files take time in proportion to their size: measured as ratios, so that a busy machine changes nothing."""

import json
import statistics
import time

import pytest

from graph.files import loads


def text(nodes):
    """A chain of nodes as JSON, one line for each node; as good as any YAML."""
    lines = ",\n".join(f'"n{i}": {{"type": "Add", "inputs": {{"a": {i}, "b": [1.5, 2, "x"]}}}}' for i in range(nodes))
    links = ",\n".join(json.dumps(f"n{i}.sum -> n{i + 1}.a") for i in range(nodes - 1))
    return f'{{"tickgraph": 1, "graphs": {{"/G": {{"nodes": {{\n{lines}}}, "connections": [\n{links}]}}}}}}'


def seconds(text, name):
    start = time.process_time()
    loads(text, name=name)
    return time.process_time() - start


@pytest.mark.parametrize(("name", "nodes"), [("a.json", 2000), ("a.yaml", 300)])
def test_four_times_the_nodes_take_about_four_times_as_long(name, nodes):
    small, large = text(nodes), text(4 * nodes)
    loads(small, name=name)
    ratios = [seconds(large, name) / seconds(small, name) for _ in range(5)]
    assert statistics.median(ratios) < 7


def test_json_takes_a_small_multiple_of_the_standard_library():
    tree = text(3000)
    loads(tree, name="a.json")

    def standard():
        start = time.process_time()
        json.loads(tree)
        return time.process_time() - start

    ratios = [seconds(tree, "a.json") / standard() for _ in range(5)]
    assert statistics.median(ratios) < 60


def test_a_file_of_twenty_thousand_nodes_is_read_whole():
    spec = loads(text(20_000), name="a.json")
    [graph] = spec.graphs
    assert len(graph.nodes) == 20_000
    assert graph.nodes[-1].inputs["a"] == 19_999
    assert graph.nodes[-1].mark.line == 20_000 + 1
    assert len(graph.connections) == 19_999
    assert graph.connections[-1].source == "n19998.sum"
