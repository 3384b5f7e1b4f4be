"""The beginning of a test file, for tests of what runs such files: line 7 has a case that passes."""

PASSES = """\
tickgraph_tests: 1
node: Countdown
inputs: {duration: 2}
pulses: {execIn: [0]}
updates: 4
cases:
  it finishes:
    expect: {fired: {finished: [2]}}
"""
