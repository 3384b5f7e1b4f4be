"""For each class of mistake the exact line a user reads."""

import pytest

from graph.base.errors import UserError
from graph.files import loads

RATE = "a rate in Hz such as 60, 29.97 or 30000/1001"
TIME = "a time in seconds such as 5, 0.5 or 1/240"
NAME = "use letters, digits and _, not starting with a digit"


def problems(text, name="a.yaml"):
    with pytest.raises(UserError) as caught:
        loads(text, name=name)
    return [str(problem).removeprefix(f"{name}:") for problem in caught.value.problems]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("graphs: {}", '1:1: there is no "tickgraph" key; a graph file starts with "tickgraph: 1"'),
        (
            "name: x\nversion: 2",
            '1:1: this is not a graph file: there is no "tickgraph" key; a graph file starts with "tickgraph: 1"',
        ),
        ("tickgraph: 2\nnew: 1", "1:12: format 2 is newer than this tickgraph reads (1); update it"),
        ("tickgraph: 0", "1:12: tickgraph must be 1, the version of the file format, found number 0"),
        ("tickgraph: '1'", '1:12: tickgraph must be 1, the version of the file format, found text "1"'),
        ("tickgraph: true", "1:12: tickgraph must be 1, the version of the file format, found true"),
        ("tickgraph: 1.0", "1:12: tickgraph must be 1, the version of the file format, found number 1.0"),
        ("tickgraph:", '1:1: there is no "tickgraph" key; a graph file starts with "tickgraph: 1"'),
        ("- a\n- b", '1:1: a graph file is a mapping that starts with "tickgraph: 1", found a list'),
        ("hello", '1:1: a graph file is a mapping that starts with "tickgraph: 1", found text "hello"'),
    ],
)
def test_files_of_another_kind_or_version(text, line):
    assert problems(text) == [line]


@pytest.mark.parametrize(
    ("body", "line"),
    [
        ("graph: {}", '2:1: unknown key "graph"; did you mean "graphs"?'),
        ("Graphs: {}", '2:1: unknown key "Graphs"; did you mean "graphs"?'),
        (
            "qqq: {}",
            '2:1: unknown key "qqq"; known are tickgraph, scene, clock, duration, settings, fidelity, randomize, '
            "graphs, record",
        ),
        ("scene: [a]", "2:8: scene must be a mapping, found a list"),
        ("scene: {usd: 5}", "2:14: scene.usd must be text, found number 5"),
        ("scene: {prim: {}}", '2:9: unknown key "prim" in scene; did you mean "prims"?'),
        ("scene: {prims: [/A]}", "2:16: scene.prims must be a mapping, found a list"),
        ("scene: {prims: {/A: Cube}}", '2:21: prim /A must be a mapping, found text "Cube"'),
        (
            "scene: {prims: {World: {}}}",
            '2:17: scene.prims: "World" is not a prim path; it starts with "/", such as /World/World',
        ),
        (
            "scene: {prims: {/World/a-b: {}}}",
            f'2:17: scene.prims: "/World/a-b" is not a prim path; "a-b" cannot be a prim name: {NAME}',
        ),
        (
            "scene: {prims: {/World/: {}}}",
            f'2:17: scene.prims: "/World/" is not a prim path; "" cannot be a prim name: {NAME}',
        ),
        (
            "scene: {prims: {/World/../X: {}}}",
            f'2:17: scene.prims: "/World/../X" is not a prim path; ".." cannot be a prim name: {NAME}',
        ),
        ("clock: 60", "2:8: clock must be a mapping, found number 60"),
        ("clock: {hz: 60}", '2:9: unknown key "hz" in clock; known are physics_hz, loop_hz, experience, parity'),
        ("clock: {physics_hz: 0}", f"2:21: clock.physics_hz must be above 0, found number 0; give {RATE}"),
        ("clock: {physics_hz: -60}", f"2:21: clock.physics_hz must be above 0, found number -60; give {RATE}"),
        ("clock: {physics_hz: -1/240}", f'2:21: clock.physics_hz must be above 0, found text "-1/240"; give {RATE}'),
        ("clock: {loop_hz: .nan}", f"2:18: clock.loop_hz must be {RATE}, found number nan"),
        ("clock: {loop_hz: -.inf}", f"2:18: clock.loop_hz must be {RATE}, found number -inf"),
        ("clock: {loop_hz: fast}", f'2:18: clock.loop_hz must be {RATE}, found text "fast"'),
        ("clock: {loop_hz: 1/0}", f'2:18: clock.loop_hz must be {RATE}, found text "1/0"'),
        ("clock: {loop_hz: true}", f"2:18: clock.loop_hz must be {RATE}, found true"),
        ("clock: {loop_hz: [60]}", f"2:18: clock.loop_hz must be {RATE}, found a list"),
        (
            "clock: {loop_hz: 1e12}",
            f"2:18: clock.loop_hz must be at most 1,000,000,000, found number 1000000000000.0; give {RATE}",
        ),
        (f"clock: {{loop_hz: {'9' * 30}}}", None),
        ("clock: {experience: ful}", '2:21: clock.experience: "ful" is not a choice; did you mean "full"?'),
        (
            "clock: {experience: 3}",
            "2:21: clock.experience: found number 3; choose one of base, full, zero_delay",
        ),
        (
            "clock: {parity: isaac}",
            '2:17: clock.parity: "isaac" is not a choice; choose one of documented, isaacsim-6.0.1',
        ),
        (
            "clock: {experience: zero_delay, physics_hz: 240, loop_hz: 60}",
            "2:33: clock: zero_delay needs physics_hz = loop_hz, found 240 and 60; give one of them",
        ),
        ("duration: 0", f"2:11: duration must be above 0, found number 0; give {TIME}"),
        ("duration: .inf", f"2:11: duration must be {TIME}, found number inf"),
        ("duration: 5 s", f'2:11: duration must be {TIME}, found text "5 s"'),
        ("settings: {rtx/a: 1}", '2:12: settings: "rtx/a" is not a setting; settings are paths such as "/app/name"'),
        (
            "settings: {/a: {b: 1}}",
            "2:16: settings: /a must be a number, text, true, false or a list of these, found a mapping",
        ),
        ("fidelity: {tlas: [1]}", "2:18: fidelity: tlas must be a number, text, true or false, found a list"),
        ("record: run.mcap", '2:9: record must be a mapping, found text "run.mcap"'),
        ("record: {mcp: a}", '2:10: unknown key "mcp" in record; did you mean "mcap"?'),
        ("graphs: [a]", "2:9: graphs must be a mapping, found a list"),
        ("graphs: {G: {}}", '2:10: graphs: "G" is not a prim path; it starts with "/", such as /World/G'),
        ("graphs: {/G: 5}", "2:14: graph /G must be a mapping, found number 5"),
        ("graphs: {/G: {node: {}}}", '2:15: unknown key "node" in graph /G; did you mean "nodes"?'),
        (
            "graphs: {/G: {evaluator: exec}}",
            '2:26: graph /G: evaluator: "exec" is not a choice; did you mean "execution"?',
        ),
        (
            "graphs: {/G: {pipeline_stage: postrender}}",
            '2:31: graph /G: pipeline_stage: "postrender" is not a choice; did you mean "post_render"?',
        ),
        ("graphs: {/G: {nodes: [a]}}", "2:22: graph /G: nodes must be a mapping, found a list"),
        (
            "graphs: {/G: {nodes: {n: 5}}}",
            '2:26: node "n" must be a type id or a mapping with a type, found number 5',
        ),
        (
            "graphs: {/G: {nodes: {n: }}}",
            '2:23: node "n" must be a type id or a mapping with a type, found nothing',
        ),
        ("graphs: {/G: {nodes: {a b: X}}}", f'2:23: graph /G: nodes: "a b" cannot be a name; {NAME}'),
        ("graphs: {/G: {nodes: {n: {inputs: {}}}}}", '2:23: node "n": "type" is missing; add it'),
        ("graphs: {/G: {nodes: {n: {typ: X}}}}", '2:27: unknown key "typ" in node "n"; did you mean "type"?'),
        (
            "graphs: {/G: {nodes: {n: {type: X, duration: 5}}}}",
            '2:36: unknown key "duration" in node "n"; known are type, inputs, state, attributes',
        ),
        ("graphs: {/G: {nodes: {n: {type: 5}}}}", '2:33: node "n": type must be text, found number 5'),
        ("graphs: {/G: {nodes: {n: ''}}}", '2:26: node "n": type is empty; give it a value'),
        (
            "graphs: {/G: {nodes: {n: {type: X, inputs: [5]}}}}",
            '2:44: node "n": inputs must be a mapping, found a list',
        ),
        (
            "graphs: {/G: {nodes: {n: {type: X, inputs: {'outputs:x': 5}}}}}",
            '2:45: node "n": "outputs:x" cannot be set; only inputs and state can',
        ),
        (
            "graphs: {/G: {nodes: {n: {type: X, inputs: {a: 1, 'inputs:a': 2}}}}}",
            '2:51: node "n": "inputs:a" is set twice; remove one',
        ),
        ("graphs: {/G: {variables: {v: 5}}}", '2:30: variable "v" must be a mapping, found number 5'),
        ("graphs: {/G: {variables: {v: {value: 5}}}}", '2:27: variable "v": "type" is missing; add it'),
        ("graphs: {/G: {variables: {v-w: {type: int}}}}", f'2:27: graph /G: variables: "v-w" cannot be a name; {NAME}'),
        ("graphs: {/G: {connections: {a: b}}}", "2:28: graph /G: connections must be a list, found a mapping"),
        ("graphs: {/G: {connections: [5]}}", "2:29: a connection must be text, found number 5"),
        (
            "graphs: {/G: {connections: [a.x]}}",
            '2:29: connection "a.x" has no arrow; write "node.output -> node.input", or "node.output -> [node.input, '
            'other.input]"',
        ),
    ],
)
def test_mistakes_in_a_file(body, line):
    found = problems(f"tickgraph: 1\n{body}\n")
    assert len(found) == 1
    if line is not None:
        assert found == [line]


def test_all_problems_come_together_in_the_order_of_the_file():
    text = """\
tickgraph: 1
clock: {loop_hz: 0, loop_hz: 60}
scene: {usd: 7}
graphs:
  /G:
    nodes:
      a: {type: X, input: 1}
      a: Y
    connections:
      - a.x
      - !!python/none b.y -> c.z
"""
    assert [line.split(": ")[0] for line in problems(text)] == ["2:18", "2:21", "3:14", "7:20", "8:7", "10:9", "11:9"]


def test_json_has_the_same_messages_as_yaml():
    text = '{"tickgraph": 1,\n "graphs": {"/G": {"nodes": {"n": {"type": "X", "input": {}}}, "connections": ["a"]}}}'
    assert problems(text, "a.json") == [
        '2:49: unknown key "input" in node "n"; did you mean "inputs"?',
        '2:80: connection "a" has no arrow; write "node.output -> node.input", or "node.output -> [node.input, '
        'other.input]"',
    ]


def test_text_from_a_file_cannot_command_the_terminal_or_break_the_line():
    [line] = problems('tickgraph: 1\n"\\e[31m\\nred": 1\n')
    assert line.startswith('2:1: unknown key "\\u001b[31m\\u000ared";')


def test_long_text_is_shortened():
    [line] = problems(f"tickgraph: 1\n{'k' * 500}: 1\n")
    assert len(line) < 200


def test_a_misspelt_required_key_is_one_problem():
    assert len(problems("tickgraph: 1\ngraphs: {/G: {nodes: {n: {Type: X}}}}\n")) == 1


def test_many_problems_are_found_in_little_time():
    nodes = "".join(f"      n{i}: {{typ: X}}\n" for i in range(2000))
    assert len(problems(f"tickgraph: 1\ngraphs:\n  /G:\n    nodes:\n{nodes}")) == 2000


def test_a_number_that_cannot_be_read_is_one_problem():
    assert problems("tickgraph: 1\nduration: 1e400\n") == ["2:11: 1e400 is larger than any double"]


def test_rates_that_zero_delay_cannot_run_are_one_problem():
    text = "tickgraph: 1\nclock: {experience: zero_delay, physics_hz: 120, loop_hz: 60}\n"
    assert problems(text) == ["2:33: clock: zero_delay needs physics_hz = loop_hz, found 120 and 60; give one of them"]
