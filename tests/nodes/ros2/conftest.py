"""Messages in plain data, and a world that hears them."""

import pytest


@pytest.fixture
def says():
    """A function: message type and its fields as plain data -> message."""
    from graph.sim.messages.ros_fields import from_plain

    return lambda type_name, **fields: from_plain(type_name, fields)


@pytest.fixture
def play():
    """A function that plays (time, topic, type, message) into an App."""
    from graph.recording.sources import MemorySource, Player

    return lambda app, *messages: Player(app, [MemorySource(messages)])


@pytest.fixture
def plain():
    """A function: the messages that an App's memory sink holds of a topic, as plain data."""
    from graph.sim.messages.ros_fields import to_plain

    return lambda app, topic: [to_plain(one.type_name, one.message) for one in app.sink[topic]]


@pytest.fixture
def run_file(tmp_path):
    """A function: runs the nodes and connections of a YAML text for some updates.

    Returns an App that has stopped updating but still plays, with a memory sink (`app.sink`) and `value(node, name)`.
    """
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

    opened = []

    def run(text, updates, *, heard=True):
        path = tmp_path / "graph.yaml"
        path.write_text("tickgraph: 1\ngraphs:\n  /G:\n" + "".join(f"    {line}\n" for line in text.splitlines()))
        app = App.from_file(path)
        opened.append(app)
        app.sink = MemorySink()
        if heard:
            app.bus.subscribe(app.sink)
        app.value = lambda node, name: app.graphs["/G"].nodes[node].get(name)
        app.play()
        app.update(updates)
        return app

    yield run
    for app in opened:
        app.close()
