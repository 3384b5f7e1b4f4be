import pytest

TEXT = """\
tickgraph: 1
graphs:
  /World/A:
    variables: {gain: {type: double, value: 2.0}}
    nodes:
      tick: OnPlaybackTick
      wait: {type: omni.graph.action.Countdown, inputs: {duration: 5}}
      odd: NoSuchType
    connections:
      - tick.tick -> [wait.execIn, odd.go]
      - tick.time -> odd.when
      - odd.out -> odd.in
  /World/B:
    pipeline_stage: post_render
    nodes: {print: NoSuchType}
    connections:
      - /World/A.wait.outputs:tickValue -> print.value
      - gone.x -> print.y
"""


@pytest.fixture
def file(folder):
    (folder / "a.yaml").write_text(TEXT)
    return "a.yaml"


def test_text_shows_values_and_tells_execution_from_data(file, graph):
    assert (
        graph("show", file).out
        == """\
/World/A (execution, simulation)
|   variable gain: double = 2.0
|-- tick: OnPlaybackTick
|       tick => wait.execIn
|       tick => odd.go
|       time -> odd.when
|-- wait: Countdown
|       duration = 5
|       tickValue -> /World/B/print.value
`-- odd: NoSuchType
        out ?> odd.in

/World/B (execution, post_render)
`-- print: NoSuchType
/World/B/gone (not in this file)
        x ?> /World/B/print.y
"""
    )


def test_mermaid_tells_execution_from_data(file, graph):
    assert (
        graph("show", file, "--format", "mermaid").out
        == """\
flowchart LR
  subgraph g0["/World/A (execution, simulation)"]
    n0["tick<br/>OnPlaybackTick"]
    n1["wait<br/>Countdown"]
    n2["odd<br/>NoSuchType"]
  end
  subgraph g1["/World/B (execution, post_render)"]
    n3["print<br/>NoSuchType"]
  end
  n4["/World/B/gone<br/>?"]
  n0 ==>|"tick → execIn"| n1
  n0 ==>|"tick → go"| n2
  n0 -->|"time → when"| n2
  n2 -.->|"out → in"| n2
  n1 -->|"tickValue → value"| n3
  n4 -.->|"x → y"| n3
"""
    )


def test_dot_tells_execution_from_data(file, graph):
    lines = graph("show", file, "--format", "dot").out.splitlines()
    assert lines[0] == "digraph tickgraph {"
    assert lines[-1] == "}"
    assert r'    n1 [label="wait\nCountdown"];' in lines
    assert '  n0 -> n1 [label="tick → execIn", style=bold];' in lines
    assert '  n0 -> n2 [label="time → when", style=solid];' in lines
    assert '  n4 -> n3 [label="x → y", style=dotted];' in lines


def test_names_cannot_break_out_of_a_drawing(folder, graph):
    (folder / "a.yaml").write_text(
        'tickgraph: 1\ngraphs: {/G: {nodes: {n: {type: "a.X\\"]; <b>\\n", inputs: {i: "\\e[31m"}}}}}\n'
    )
    assert 'n0["n<br/>X&quot;]; &lt;b&gt;\\u000a"]' in graph("show", "a.yaml", "--format", "mermaid").out
    assert r'[label="n\nX\"]; <b>\\u000a"]' in graph("show", "a.yaml", "--format", "dot").out
    assert "\x1b" not in graph("show", "a.yaml").out


def test_a_file_with_mistakes_is_drawn_as_far_as_it_goes(folder, graph):
    (folder / "a.yaml").write_text("tickgraph: 1\nx: 1\ngraphs: {/G: {nodes: {n: X}}}\n")
    result = graph("show", "a.yaml")
    assert result.code == 2
    assert result.out == "/G (execution, simulation)\n`-- n: X\n"
    assert result.err.startswith('a.yaml:2:1: unknown key "x"')


def test_a_file_that_cannot_be_read_is_not_drawn(folder, graph):
    result = graph("show", "none.yaml")
    assert (result.code, result.out) == (2, "")
    assert result.err == "graph: none.yaml: no such file\n"


def test_pictures_show_the_values_of_inputs_on_request(graph, tmp_path):
    text = "graphs: {/G: {nodes: {c: {type: Countdown, inputs: {duration: 5, period: 2}}}}}"
    (tmp_path / "v.yaml").write_text(f"tickgraph: 1\n{text}\n")

    assert "duration" not in graph("show", tmp_path / "v.yaml", "--format", "dot").out
    assert (
        '"c\\nCountdown\\nduration = 5\\nperiod = 2"'
        in graph("show", tmp_path / "v.yaml", "--format", "dot", "--values").out
    )
    mermaid = graph("show", tmp_path / "v.yaml", "--format", "mermaid", "--values").out
    assert "c<br/>Countdown<br/>duration = 5<br/>period = 2" in mermaid
