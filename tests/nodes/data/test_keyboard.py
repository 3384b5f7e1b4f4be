import pytest

from graph import UserError
from graph.sim.keyboard import keyboard_of
from graph.testing import run_node
from tests.support.without_wing import needs_wing


def test_keys_and_modifiers_are_read_while_they_are_down(world):
    app = world()
    keyboard = keyboard_of(app)

    def hands(update, node):
        {1: lambda: keyboard.press("B"), 2: lambda: keyboard.press("LeftShift"), 3: lambda: keyboard.release("B")}.get(
            update, lambda: None
        )()

    trace = run_node("ReadKeyboardState", inputs={"key": "B"}, updates=4, app=app, on_update=hands)
    assert trace.values("isPressed") == [False, True, True, False]
    assert trace.values("shiftOut") == [False, False, True, True]
    assert trace.values("altOut") == trace.values("ctrlOut") == [False] * 4


def test_listeners_hear_of_each_change_once(world):
    keyboard = keyboard_of(world())
    heard = []
    end = keyboard.listen(lambda key, down: heard.append((key, down)))
    for _ in range(2):
        keyboard.press("A")
    keyboard.release("A")
    end()
    keyboard.press("A")
    assert heard == [("A", True), ("A", False)]


def test_a_key_that_is_not_there_is_refused(world):
    with pytest.raises(UserError, match=r'there is no key "space"; did you mean "Space"\?'):
        keyboard_of(world()).press("space")


def test_two_apps_have_two_keyboards(world):
    assert keyboard_of(world()) is not keyboard_of(world())


@needs_wing("replicator")
def test_the_entry_of_a_saved_pipeline_does_nothing_without_frames(world):
    assert run_node("GpuInteropRenderProductEntry", updates=3, app=world()).fired("exec") == []


@needs_wing("replicator")
def test_the_entry_of_a_saved_pipeline_fires_for_new_frames(world, lidar):
    from sensors import render_product

    path = lidar()
    app = world(physics_hz=60, loop_hz=60)
    render_product(app, path)
    trace = run_node("GpuInteropRenderProductEntry", updates=14, app=app, phase="post_render_graphs")
    assert trace.fired("exec") != []
    assert trace.value("simTime") == pytest.approx(trace.value("hydraTime"))


@needs_wing("replicator")
def test_the_entry_gives_the_time_of_the_frame_not_that_of_its_update(world, lidar):
    # A tick at 0.1 s lies in the third update of 1/24 s, which ends at 0.125 s: the scan shows step 24 of 240 Hz.
    from sensors import render_product

    path = lidar()
    app = world(physics_hz=240, loop_hz=24)
    render_product(app, path)
    trace = run_node("GpuInteropRenderProductEntry", updates=4, app=app, phase="post_render_graphs")
    assert trace.fired("exec") == [2]
    assert (trace.value("simTime"), trace.value("hydraTime")) == (0.1, 0.1)
