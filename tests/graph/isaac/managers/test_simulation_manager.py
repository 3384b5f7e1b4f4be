"""SimulationManager, row by row: setup, steps, lifecycle, events, callbacks, engines; the table of play and stop."""

from __future__ import annotations

import gc
import itertools
import logging
from fractions import Fraction

import pytest

from graph.base.errors import RunError, UserError
from graph.sim import App, IsaacEvents, RenderingManager, SimulationEvent, SimulationManager
from graph.sim import settings as keys
from graph.sim.scene.prims import author_prims
from graph.sim.usd import UsdPhysics, UsdUtils
from tests.support.listeners import Listener

PRODUCT = "isaacsim-6.0.1"
PARITIES = ["documented", PRODUCT]
BALL = {"/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 5], "rigid_body": True, "mass": 1.0}}
EXTERNAL = ("/ExternalSimulationTime", "omni:time")


def hear(app, *events, order=0):
    """A list that fills with the names of events as they come."""
    heard = []
    for event in events:
        app.simulation.register_callback(lambda *args, event=event: heard.append(event.name), event, order=order)
    return heard


LIFECYCLE = (
    SimulationEvent.SIMULATION_SETUP,
    SimulationEvent.SIMULATION_STARTED,
    SimulationEvent.SIMULATION_PAUSED,
    SimulationEvent.SIMULATION_RESUMED,
    SimulationEvent.SIMULATION_STOPPED,
)


# -- setup ---------------------------------------------------------------------------------------------------------


def test_setup_simulation_makes_a_physics_scene_if_there_is_none():
    with App() as app:
        app.simulation.setup_simulation()
        assert app.stage.GetPrimAtPath("/PhysicsScene").IsA(UsdPhysics.Scene)


def test_setup_simulation_sets_dt_on_every_scene():
    with App() as app:
        for path in ("/A", "/B"):
            UsdPhysics.Scene.Define(app.stage, path)
        app.simulation.setup_simulation(dt=1 / 240)
        assert [scene.get_dt() for scene in app.simulation.get_physics_scenes()] == [1 / 240, 1 / 240]
        assert app.simulation.steps_per_second == 240
        assert len(app.warnings) == 0


def test_setup_simulation_is_allowed_while_playing_and_outlasts_the_stop():
    with App() as app:
        app.simulation.setup_simulation()
        app.play()
        app.update()
        app.simulation.setup_simulation(dt=1 / 120)
        app.update()
        assert app.simulation.get_num_physics_steps() == 3
        app.stop()
        assert app.stage.GetPrimAtPath("/PhysicsScene").GetAttribute("physxScene:timeStepsPerSecond").Get() == 120
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 2


def test_setup_simulation_makes_no_prim_while_playing():
    with App() as app:
        app.play()
        app.simulation.setup_simulation(dt=1 / 120)
        assert app.simulation.get_physics_scenes() == []
        assert app.simulation.get_physics_dt() == 1 / 120


@pytest.mark.parametrize("dt", [0, -1e-9, 1.001, float("inf"), Fraction(1, 10**10)])
def test_setup_simulation_refuses_a_dt_and_changes_nothing(dt):
    with App() as app:
        with pytest.raises(ValueError, match=r"dt|finite"):
            app.simulation.setup_simulation(dt=dt)
        assert app.simulation.steps_per_second == 60


def test_setup_simulation_with_another_device_changes_nothing():
    with App() as app:
        with pytest.raises(ValueError, match="GPU is missing"):
            app.simulation.setup_simulation(dt=1 / 240, device="cuda:0")
        assert app.simulation.steps_per_second == 60


def test_set_physics_dt_runtime_error_while_playing():
    with App() as app:
        app.play()
        with pytest.raises(RuntimeError, match="while playing"):
            app.simulation.set_physics_dt(1 / 120)


@pytest.mark.parametrize("dt", [-0.1, 1.1])
def test_set_physics_dt_value_error_outside_0_to_1(dt):
    with App() as app, pytest.raises(ValueError, match="from 0 to 1 s"):
        app.simulation.set_physics_dt(dt)


def test_set_physics_dt_of_one_scene_and_of_all_for_an_unknown_path():
    with App() as app:
        for path in ("/A", "/B"):
            UsdPhysics.Scene.Define(app.stage, path)
        app.simulation.set_physics_dt(1 / 50, "/B")
        assert [app.simulation.get_physics_dt(path) for path in ("/A", "/B")] == [1 / 60, 1 / 50]
        app.simulation.set_physics_dt(1 / 100, "/Nowhere")
        assert [app.simulation.get_physics_dt(path) for path in ("/A", "/B")] == [1 / 100, 1 / 100]
        assert app.simulation.steps_per_second == 100


def test_get_physics_dt_first_scene_when_not_found_and_creates_one_if_none():
    with App(physics_hz=240) as app:
        assert app.simulation.get_physics_dt("/Nowhere") == 1 / 240
        assert [scene.path for scene in app.simulation.get_physics_scenes()] == ["/PhysicsScene"]


@pytest.mark.parametrize(("parity", "rate"), [("documented", 99), (PRODUCT, 98)])
def test_trap_3_a_dt_is_exact_or_truncated_to_whole_steps_per_second(parity, rate):
    with App(parity=parity) as app:
        app.simulation.setup_simulation(dt=1 / 99)
        assert app.simulation.steps_per_second == rate


def test_a_rate_that_is_not_a_whole_number_is_kept_on_the_stage_as_a_time_step():
    with App() as app:
        app.simulation.setup_simulation(dt=Fraction(2, 199))
        assert app.simulation.steps_per_second == Fraction(199, 2)
        with App(stage=app.stage) as again:
            assert again.simulation.steps_per_second == Fraction(199, 2)


# -- readings and step ---------------------------------------------------------------------------------------------


def test_step_direct_pdt_steps_no_accumulator_no_timeline_no_render():
    with App(physics_hz=100) as app:
        app.play()
        updates = app.update_index
        app.simulation.step(steps=7)
        assert app.simulation.get_num_physics_steps() == 7
        assert app.simulation.get_simulation_time() == 0.07
        assert (app.timeline.current_time, app.update_index) == (0, updates)


def test_step_callback_i_from_1_and_false_stops_early():
    with App() as app:
        app.play()
        calls = []
        app.simulation.step(steps=10, callback=lambda i, steps: calls.append((i, steps)) or i < 3)
        assert calls == [(1, 10), (2, 10), (3, 10)]
        assert app.simulation.get_num_physics_steps() == 3


def test_step_callback_that_stops_the_simulation_ends_the_steps():
    with App() as app:
        app.play()
        app.simulation.step(steps=10, callback=lambda i, steps: app.stop())
        assert app.simulation.get_num_physics_steps() == 0


def test_step_of_none_is_nothing_and_of_fewer_is_refused():
    with App() as app:
        app.play()
        app.simulation.step(steps=0)
        with pytest.raises(ValueError, match=r"^steps -3: give 0 or more$"):
            app.simulation.step(steps=-3)
        assert (app.simulation.get_num_physics_steps(), app.simulation.get_sample_count()) == (0, 0)


def test_step_value_error_if_update_fabric_without_fabric():
    with App(fidelity={"fabric": False}) as app:
        app.play()
        with pytest.raises(ValueError, match="enable_fabric"):
            app.simulation.step(update_fabric=True)
        app.simulation.step()
    with App() as app:
        app.play()
        app.simulation.step(update_fabric=True)


def test_step_needs_a_world():
    with App() as app, pytest.raises(RunError, match=r"app\.play\(\)"):
        app.simulation.step()


# -- the table of events -------------------------------------------------------------------------------------------


def clocks(app):
    simulation = app.simulation
    return {
        "timeline": app.timeline.current_time,
        "time": simulation.time,
        "monotonic": simulation.monotonic_time,
        "steps": simulation.get_num_physics_steps(),
        "external": app.fabric.get(*EXTERNAL),
        "simulating": simulation.is_simulating(),
        "paused": simulation.is_paused(),
    }


@pytest.mark.parametrize(("parity", "warm_up"), [("documented", 0), (PRODUCT, 2)])
def test_row_play_from_stopped(parity, warm_up):
    with App(physics_hz=100, parity=parity) as app:
        app.play()
        assert clocks(app) == {
            "timeline": 0,
            "time": Fraction(warm_up, 100),
            "monotonic": Fraction(warm_up, 100),
            "steps": warm_up,
            "external": warm_up / 100,
            "simulating": True,
            "paused": False,
        }
        assert app.simulation.carry == 0


def test_row_update_playing_with_steps():
    with App(physics_hz=120) as app:
        app.play()
        app.update()
        now = clocks(app)
        assert (now["timeline"], now["time"], now["steps"]) == (Fraction(1, 60), Fraction(1, 60), 2)
        assert (now["external"], now["simulating"]) == (1 / 60, True)


def test_row_update_playing_without_a_step_moves_the_timeline_alone():
    with App(physics_hz=30) as app:
        app.play()
        before = clocks(app)
        app.update()
        assert clocks(app) == {**before, "timeline": Fraction(1, 60)}


def test_row_pause_then_updates_trap_8_is_simulating_is_still_true():
    with App() as app:
        app.play()
        app.update(3)
        before = clocks(app)
        app.pause()
        app.update(5)
        assert clocks(app) == {**before, "simulating": True, "paused": True}


@pytest.mark.parametrize("parity", PARITIES)
def test_row_resume_continues_without_warm_up(parity):
    with App(parity=parity) as app:
        app.play()
        app.update()
        app.pause()
        before = clocks(app)
        app.play()
        assert clocks(app) == {**before, "simulating": True, "paused": False}


def test_row_stop():
    with App() as app:
        app.play()
        app.update(6)
        app.stop()
        assert clocks(app) == {
            "timeline": 0,
            "time": 0,
            "monotonic": Fraction(1, 10),
            "steps": 0,
            "external": 0.0,
            "simulating": False,
            "paused": False,
        }
        assert app.simulation.get_sample_count() == 0


def test_row_step_k():
    with App(physics_hz=50) as app:
        app.play()
        before = clocks(app)
        app.simulation.step(steps=5)
        moved = {"time": Fraction(1, 10), "monotonic": Fraction(1, 10), "steps": 5, "external": 0.1}
        assert clocks(app) == {**before, **moved}


def test_row_sps_changed_between_steps_trap_4():
    """60 steps at 60 Hz, then 120 Hz: the next time is 61/120, only the monotonic time goes on."""
    with App() as app:
        app.play()
        app.simulation.step(steps=60)
        app.simulation.setup_simulation(dt=1 / 120)
        app.simulation.step()
        assert app.simulation.time == Fraction(61, 120)
        assert app.simulation.monotonic_time == 1 + Fraction(1, 120)


def test_the_monotonic_example_of_the_product():
    """60 Hz, play, 1 update, step(100), stop, play, 1 update: monotonic 106/60, simulation 3/60."""
    with App(parity=PRODUCT) as app:
        app.play()
        app.update()
        app.simulation.step(steps=100)
        app.stop()
        app.play()
        app.update()
        assert (app.simulation.monotonic_time, app.simulation.time) == (Fraction(106, 60), Fraction(3, 60))


def test_play_simulations_off_at_play_warms_up_by_hand():
    with App(parity=PRODUCT, settings={keys.PLAY_SIMULATIONS: False}) as app:
        heard = hear(app, *LIFECYCLE)
        app.play()
        app.update(3)
        assert (heard, app.simulation.get_num_physics_steps(), app.simulation.warm) == ([], 0, False)
        app.simulation.initialize_physics()
        assert (heard, app.simulation.get_num_physics_steps()) == (["SIMULATION_SETUP"], 2)


# -- initialize and invalidate -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("parity", "warm_up"), [("documented", 0), (PRODUCT, 2)])
def test_initialize_physics_is_the_warm_up_and_no_op_if_already_warm(parity, warm_up):
    with App(parity=parity) as app:
        author_prims(app.stage, BALL)
        heard = hear(app, *LIFECYCLE)
        app.simulation.initialize_physics()
        app.simulation.initialize_physics()
        assert heard == ["SIMULATION_SETUP"]
        assert app.simulation.get_num_physics_steps() == warm_up
        assert app.simulation.is_simulating()
        assert app.timeline.is_stopped()
        assert app.physics is not None
        app.simulation.step(steps=3)
        app.play()
        assert heard == ["SIMULATION_SETUP", "SIMULATION_RESUMED"]
        assert app.simulation.get_num_physics_steps() == warm_up + 3


@pytest.mark.parametrize("end", [lambda app: app.simulation.invalidate_physics(), lambda app: app.stop()])
def test_a_world_built_by_hand_is_freed_and_the_stage_put_back(end):
    with App() as app:
        author_prims(app.stage, BALL)
        before = app.stage.GetRootLayer().ExportToString()
        app.simulation.initialize_physics()
        app.simulation.step(steps=30)
        end(app)
        assert (app.physics, app.simulation.is_simulating(), app.simulation.time) == (None, False, 0)
        assert app.stage.GetRootLayer().ExportToString() == before
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 1


def test_invalidate_physics_the_next_play_warms_up_again():
    with App(parity=PRODUCT) as app:
        heard = hear(app, *LIFECYCLE)
        app.play()
        app.simulation.invalidate_physics()
        assert app.simulation.get_physics_simulation_view() is None
        app.pause()
        app.play()
        assert heard == ["SIMULATION_SETUP", "SIMULATION_STARTED", "SIMULATION_PAUSED", *heard[:2]]
        assert app.simulation.get_num_physics_steps() == 4


def test_get_physics_simulation_view_none_before_play_and_after_stop():
    with App() as app:
        author_prims(app.stage, BALL)
        assert app.simulation.get_physics_simulation_view() is None
        app.play()
        app.update()
        view = app.simulation.get_physics_simulation_view()
        assert view is app.simulation.tensors
        assert view.positions.shape == (1, 3)
        app.stop()
        assert app.simulation.get_physics_simulation_view() is None


# -- events --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("event", "value"),
    [
        ("PHYSICS_PRE_STEP", "physics_pre_step"),
        ("PHYSICS_POST_STEP", "physics_post_step"),
        ("SIMULATION_SETUP", "simulation_setup"),
        ("SIMULATION_STARTED", "started"),
        ("SIMULATION_PAUSED", "paused"),
        ("SIMULATION_RESUMED", "resumed"),
        ("SIMULATION_STOPPED", "stopped"),
        ("PRIM_DELETED", "prim_deleted"),
    ],
)
def test_values_of_the_simulation_events(event, value):
    assert SimulationEvent[event] == SimulationEvent[event].value == f"isaacsim.simulation.{value}"


def test_setup_at_the_end_of_the_warm_up_started_right_after_paused_resumed_stopped():
    with App() as app:
        heard = hear(app, *LIFECYCLE)
        app.play()
        assert heard == ["SIMULATION_SETUP", "SIMULATION_STARTED"]
        app.pause()
        app.play()
        app.stop()
        assert heard[2:] == ["SIMULATION_PAUSED", "SIMULATION_RESUMED", "SIMULATION_STOPPED"]
        app.play()
        assert heard[5:] == ["SIMULATION_SETUP", "SIMULATION_STARTED"]


def test_the_events_are_reported_with_an_event():
    with App() as app:
        heard = []
        app.simulation.register_callback(heard.append, SimulationEvent.SIMULATION_STARTED)
        app.play()
        assert [event.event_name for event in heard] == ["isaacsim.simulation.started"]


def test_an_uncommitted_play_tells_its_events_in_the_next_update():
    with App() as app:
        heard = hear(app, *LIFECYCLE)
        app.timeline.play()
        assert heard == []
        app.update()
        assert heard == ["SIMULATION_SETUP", "SIMULATION_STARTED"]


@pytest.mark.parametrize("parity", PARITIES)
def test_physics_steps_around_each_substep_not_in_warm_up(parity):
    with App(physics_hz=120, parity=parity) as app:
        raw = []
        app.on("physics_post_step", lambda: raw.append(app.simulation.get_num_physics_steps()))
        heard = hear(app, SimulationEvent.PHYSICS_PRE_STEP, SimulationEvent.PHYSICS_POST_STEP)
        app.play()
        warm_up = app.settings.get(keys.WARM_UP_STEPS)
        assert (raw, heard) == ([*range(1, warm_up + 1)], [])
        app.update()
        assert heard == ["PHYSICS_PRE_STEP", "PHYSICS_POST_STEP"] * 2
        app.simulation.step()
        assert len(heard) == 6


def test_physics_step_callbacks_get_dt_and_context_and_negative_orders_the_old_clocks():
    with App(physics_hz=240) as app:
        app.simulation.setup_simulation()
        told = {}
        events = (SimulationEvent.PHYSICS_PRE_STEP, SimulationEvent.PHYSICS_POST_STEP)
        for event, order in itertools.product(events, (-1, 0, 1)):
            app.simulation.register_callback(
                lambda dt, context, key=(event.name, order): told.setdefault(key, (dt, context)), event, order=order
            )
        app.play()
        app.simulation.step()
        assert {dt for dt, _ in told.values()} == {1 / 240}
        assert {context.scene_path for _, context in told.values()} == {"/PhysicsScene"}
        assert {key: (context.step, context.time) for key, (_, context) in told.items()} == {
            ("PHYSICS_PRE_STEP", -1): (0, 0),
            ("PHYSICS_PRE_STEP", 0): (0, 0),
            ("PHYSICS_PRE_STEP", 1): (0, 0),
            ("PHYSICS_POST_STEP", -1): (0, 0),
            ("PHYSICS_POST_STEP", 0): (1, Fraction(1, 240)),
            ("PHYSICS_POST_STEP", 1): (1, Fraction(1, 240)),
        }
        assert list(told)[:3] == [("PHYSICS_PRE_STEP", -1), ("PHYSICS_PRE_STEP", 0), ("PHYSICS_PRE_STEP", 1)]


def test_the_callbacks_dt_follows_a_change_of_rate():
    with App() as app:
        heard = []
        app.simulation.register_callback(lambda dt, context: heard.append(dt), SimulationEvent.PHYSICS_POST_STEP)
        app.play()
        app.simulation.step()
        app.simulation.setup_simulation(dt=1 / 240)
        app.simulation.step()
        assert heard == [1 / 60, 1 / 240]


def test_prim_deleted_is_called_with_the_path_of_the_topmost_prim():
    with App() as app:
        for path in ("/World/A/B", "/World/A/C", "/World/AB"):
            app.stage.DefinePrim(path)
        heard = []
        app.simulation.register_callback(heard.append, SimulationEvent.PRIM_DELETED)
        app.stage.DefinePrim("/World/New/Below")
        assert heard == []
        app.stage.RemovePrim("/World/A")
        app.stage.RemovePrim("/World/New/Below")
        assert heard == ["/World/A", "/World/New/Below"]


def test_prim_deleted_by_a_stop_that_takes_away_what_came_while_playing():
    with App() as app:
        app.stage.DefinePrim("/World")
        heard = []
        app.simulation.register_callback(heard.append, SimulationEvent.PRIM_DELETED)
        app.play()
        app.stage.DefinePrim("/World/Spawned")
        app.stop()
        assert heard == ["/World/Spawned"]


def test_enable_usd_notice_handler_false_silences_prim_deleted():
    with App() as app:
        app.stage.DefinePrim("/World/A")
        app.stage.DefinePrim("/World/B")
        app.stage.DefinePrim("/World/C")
        heard = []
        app.simulation.register_callback(heard.append, SimulationEvent.PRIM_DELETED)
        app.simulation.enable_usd_notice_handler(False)
        app.stage.RemovePrim("/World/A")
        app.simulation.enable_usd_notice_handler(True)
        app.stage.RemovePrim("/World/B")
        app.simulation.deregister_callback(2)
        app.stage.RemovePrim("/World/C")
        assert heard == ["/World/B"]


# -- registering ---------------------------------------------------------------------------------------------------


def test_lower_order_fires_first_ties_in_registration_order():
    with App() as app:
        heard = []
        for name, order in (("b", 0), ("late", 9), ("c", 0), ("early", -9)):
            app.simulation.register_callback(
                lambda event, name=name: heard.append(name), SimulationEvent.SIMULATION_STARTED, order=order
            )
        app.play()
        assert heard == ["early", "b", "c", "late"]


def test_the_first_user_id_on_a_fresh_stage_is_2_and_events_share_the_counter():
    with App() as app:
        register = app.simulation.register_callback
        uids = [register(print, event) for event in (*LIFECYCLE, SimulationEvent.PHYSICS_PRE_STEP)]
        assert uids == [2, 3, 4, 5, 6, 7]


def test_an_event_may_be_given_by_its_value_or_by_keyword():
    with App() as app:
        heard = []
        app.simulation.register_callback(heard.append, "isaacsim.simulation.started")
        app.simulation.register_callback(callback=heard.append, event=SimulationEvent.SIMULATION_STARTED)
        app.play()
        assert len(heard) == 2


def test_register_callback_value_error_on_a_bad_event():
    with App() as app, pytest.raises(ValueError, match="PHYSICS_PRE_STEP, PHYSICS_POST_STEP"):
        app.simulation.register_callback(print, "isaacsim.simulation.sometime")


def test_register_callback_name_only_warns():
    with App() as app:
        assert app.simulation.register_callback(print, SimulationEvent.SIMULATION_STARTED, name="mine") == 2
        assert "callback-name-ignored" in app.warnings.codes()
        with pytest.raises(TypeError, match="not when="):
            app.simulation.register_callback(print, SimulationEvent.SIMULATION_STARTED, when=1)


def test_trap_10_the_simulation_manager_takes_callback_then_event():
    with App() as app, pytest.raises(ValueError, match=r"register_callback\(callback, event\)"):
        app.simulation.register_callback(SimulationEvent.SIMULATION_STARTED, print)


def test_deregister_callback_false_and_warning_when_unknown():
    with App() as app:
        heard = []
        uid = app.simulation.register_callback(heard.append, SimulationEvent.SIMULATION_STARTED)
        assert app.simulation.deregister_callback(uid) is True
        assert app.simulation.deregister_callback(uid) is False
        assert "unknown-callback" in app.warnings.codes()
        app.play()
        assert heard == []


def test_deregister_all_callbacks_does_not_remove_prim_deleted_callbacks():
    with App() as app:
        app.stage.DefinePrim("/World")
        heard = hear(app, *SimulationEvent)
        app.simulation.deregister_all_callbacks()
        app.play()
        app.update()
        app.stop()
        app.stage.RemovePrim("/World")
        assert heard == ["PRIM_DELETED"]


def test_trap_11_bound_methods_of_every_event_are_weak():
    with App() as app:
        listener, kept = Listener(), Listener()
        for event in SimulationEvent:
            app.simulation.register_callback(listener.listen, event)
            app.simulation.register_callback(kept.listen, event)
        heard = listener.heard
        del listener
        gc.collect()
        app.play()
        app.update()
        assert heard == []
        assert len(kept.heard) == 4
        assert "callback-dropped" in app.warnings.codes()
        assert not [uid for uid in range(2, 18, 2) if app.simulation.deregister_callback(uid)]


def test_trap_11_closing_the_stage_drops_all_callbacks():
    app = App()
    with app:
        listener = Listener()
        app.simulation.register_callback(listener.listen, SimulationEvent.PRIM_DELETED)
        app.stage.DefinePrim("/World")
    app.stage.RemovePrim("/World")
    assert listener.heard == []
    assert app.simulation.deregister_callback(2) is False


def test_nothing_is_called_where_nobody_subscribed():
    """The loop without hooks is the plain one: no subscriber hangs in the substeps."""
    with App() as app:
        uid = app.simulation.register_callback(print, SimulationEvent.PHYSICS_PRE_STEP)
        app.simulation.register_callback(print, SimulationEvent.SIMULATION_STOPPED)
        app.simulation.deregister_callback(uid)
        assert not app.simulation.pre_step
        assert not app.simulation.post_step


def test_a_callback_that_raises_at_play_leaves_the_world_stopped():
    with App() as app:
        uid = app.simulation.register_callback(lambda event: 1 / 0, SimulationEvent.SIMULATION_SETUP)
        with pytest.raises(ZeroDivisionError):
            app.play()
        assert app.timeline.is_stopped()
        assert not app.simulation.is_simulating()
        app.simulation.deregister_callback(uid)
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 1


# -- default callbacks ---------------------------------------------------------------------------------------------


def test_trap_12_warm_start_alone_turns_the_other_three_off_and_it_is_reported():
    with App() as app:
        app.simulation.enable_default_callbacks(enable_warm_start=True)
        assert app.simulation.get_default_callback_status() == {
            "warm_start": True,
            "on_stop": False,
            "stage_open": False,
            "stage_close": False,
            "post_warm_start": True,
        }
        assert "default-callbacks-off" in app.warnings.codes()


def test_enable_all_default_callbacks():
    with App() as app:
        app.simulation.enable_all_default_callbacks(False)
        assert set(app.simulation.get_default_callback_status().values()) == {False}
        app.simulation.enable_all_default_callbacks()
        assert set(app.simulation.get_default_callback_status().values()) == {True}


def test_is_default_callback_enabled_unknown_name_false():
    with App() as app:
        assert app.simulation.is_default_callback_enabled("on_stop") is True
        assert app.simulation.is_default_callback_enabled("sometime") is False


def test_without_warm_start_a_play_neither_warms_up_nor_tells():
    with App(parity=PRODUCT) as app:
        app.simulation.enable_default_callbacks(
            enable_warm_start=False, enable_on_stop=True, enable_stage_open=True, enable_stage_close=True
        )
        heard = hear(app, *LIFECYCLE, SimulationEvent.PHYSICS_POST_STEP)
        app.play()
        app.update()
        assert (heard, app.simulation.get_num_physics_steps()) == ([], 1)
        app.simulation.initialize_physics()
        app.update()
        assert heard == ["SIMULATION_SETUP", "PHYSICS_POST_STEP"]


def test_without_on_stop_the_next_play_is_a_resume():
    with App(parity=PRODUCT) as app:
        heard = hear(app, *LIFECYCLE)
        app.simulation.enable_default_callbacks(
            enable_warm_start=True, enable_on_stop=False, enable_stage_open=True, enable_stage_close=True
        )
        app.play()
        app.stop()
        app.play()
        assert heard == ["SIMULATION_SETUP", "SIMULATION_STARTED", "SIMULATION_STOPPED", "SIMULATION_RESUMED"]
        assert app.simulation.get_num_physics_steps() == 0


# -- engines, device, Fabric ---------------------------------------------------------------------------------------


def test_set_device_cpu_works_another_is_a_value_error_naming_what_is_missing():
    with App() as app:
        app.simulation.set_device("cpu")
        assert app.simulation.get_device() == "cpu"
        for device in ("cuda:0", "gpu", ""):
            with pytest.raises(ValueError, match='GPU is missing; use "cpu"'):
                app.simulation.set_device(device)


def test_the_engine_is_mujoco():
    with App() as app:
        assert app.simulation.get_active_physics_engine() == "mujoco"
        assert app.simulation.get_default_engine() == "mujoco"
        assert app.simulation.get_available_physics_engines(verbose=True) == [("mujoco", True)]


def test_switch_physics_engine_case_insensitive_unknown_false_and_error_log(caplog):
    with App() as app, caplog.at_level(logging.ERROR):
        assert app.simulation.switch_physics_engine("MuJoCo") is True
        assert not caplog.records
        for engine in ("physx", "newton"):
            assert app.simulation.switch_physics_engine(engine) is False
            assert f'"{engine}" is not available' in caplog.text
        assert app.simulation.get_active_physics_engine() == "mujoco"


def test_a_default_engine_that_is_not_there_is_a_warning():
    with App(settings={"/exts/isaacsim.core.simulation_manager/default_engine": "physx"}) as app:
        assert "physics-engine-unavailable" in app.warnings.codes()


def test_enable_fabric_on_turns_the_usd_write_back_settings_off():
    with App() as app:
        app.simulation.enable_fabric(True)
        assert app.simulation.is_fabric_enabled() is True
        assert app.settings.get("/physics/updateToUsd") is False
        app.simulation.enable_fabric(False)
        assert app.simulation.is_fabric_enabled() is False
        assert app.settings.get("/physics/updateVelocitiesToUsd") is True
        app.play()
        with pytest.raises(RunError, match=r"app\.stop\(\)"):
            app.simulation.enable_fabric(True)


def test_enable_fabric_usd_notice_handler():
    with App() as app:
        author_prims(app.stage, {"/World/Box": {"type": "Cube", "translate": [1, 0, 0]}})
        box = app.stage.GetPrimAtPath("/World/Box")

        def move(x):
            box.GetAttribute("xformOp:translate").Set((x, 0, 0))
            return float(app.fabric.world_matrix("/World/Box")[0, 3])

        assert move(2) == 2
        app.simulation.enable_fabric_usd_notice_handler(app.stage, False)
        assert app.simulation.is_fabric_usd_notice_handler_enabled(app.stage) is False
        assert move(3) == 2
        app.simulation.enable_fabric_usd_notice_handler(app.stage, True)
        assert move(4) == 4


def test_the_fabric_notice_handler_takes_the_stages_id():
    with App() as app:
        cache = UsdUtils.StageCache.Get()
        number = cache.Insert(app.stage).ToLongInt()
        try:
            assert app.simulation.is_fabric_usd_notice_handler_enabled(number) is True
            with pytest.raises(ValueError, match="not that of this App"):
                app.simulation.is_fabric_usd_notice_handler_enabled(number + 1)
        finally:
            cache.Erase(app.stage)


def test_assets_loading_is_false():
    with App() as app:
        assert app.simulation.assets_loading() is False


def test_the_older_events_come_between_setup_and_started_each_with_a_warning():
    with App() as app:
        order = []
        wanted = (SimulationEvent.SIMULATION_STARTED, *[*IsaacEvents][2::-1], SimulationEvent.SIMULATION_SETUP)
        for event in wanted:
            app.simulation.register_callback(lambda event: order.append(event.event_name), event)
        app.play()
        app.pause()
        app.play()
        assert order == [
            "isaacsim.simulation.simulation_setup",
            "isaac.physics_warmup",
            "isaac.simulation_view_created",
            "isaac.physics_ready",
            "isaacsim.simulation.started",
        ]
        told = [(one.where, one.message) for one in app.warnings if one.code == "event-deprecated"]
        assert told == [
            ("PHYSICS_READY", "this event is deprecated; use SimulationEvent.SIMULATION_STARTED"),
            ("SIMULATION_VIEW_CREATED", "this event is deprecated; use SimulationEvent.SIMULATION_SETUP"),
            ("PHYSICS_WARMUP", "this event is deprecated; use SimulationEvent.SIMULATION_SETUP"),
        ]


def test_older_names_of_present_events_are_those_events():
    with App() as app:
        seen = []
        for event in (IsaacEvents.PRE_PHYSICS_STEP, IsaacEvents.POST_PHYSICS_STEP):
            app.simulation.register_callback(lambda dt, context, event=event: seen.append((event.name, dt)), event)
        app.simulation.register_callback(lambda event: seen.append("stopped"), IsaacEvents.TIMELINE_STOP)
        app.play()
        app.update()
        app.stop()
    assert seen == [("PRE_PHYSICS_STEP", 1 / 60), ("POST_PHYSICS_STEP", 1 / 60), "stopped"]


def test_older_events_have_isaac_sim_s_names_and_nothing_raises_that_of_resets():
    names = "physics_warmup simulation_view_created physics_ready post_reset pre_physics_step post_physics_step"
    names += " timeline_stop prim_deletion"
    assert [(each.name, each.value) for each in IsaacEvents] == [
        (name.upper(), f"isaac.{name}") for name in names.split()
    ]
    with App() as app:
        seen = []
        app.simulation.register_callback(seen.append, IsaacEvents.POST_RESET)
        app.play()
        app.update()
        app.stop()
        told = [one.message for one in app.warnings if one.code == "event-deprecated"]
    message = "this event is deprecated; nothing raises it here; use SimulationEvent.SIMULATION_STARTED"
    assert (seen, told) == ([], [message])


# -- the raw interface ---------------------------------------------------------------------------------------------


def test_raw_interface_times_at_a_time():
    with App() as app:
        app.play()
        app.update(60)
        raw = app.simulation._simulation_manager_interface
        assert raw.get_simulation_time_at_time((1, 2)) == 0.5
        assert raw.get_simulation_time_at_time(Fraction(1, 2)) == 0.5
        assert raw.get_simulation_time_monotonic_at_time((1, 2)) == 0.5
        assert raw.get_simulation_time_at_time((0, 0)) == 1.0
        assert raw.get_system_time_at_time((1, 1)) == raw.get_system_time()
        assert raw.get_current_time() == 1
        assert (raw.get_sample_count(), raw.get_buffer_capacity(), len(raw.get_all_samples())) == (31, 31, 31)
        assert raw.get_sample_range() == (Fraction(30, 60), 1)
        raw.log_statistics()


def test_raw_interface_of_an_empty_store():
    with App() as app:
        raw = app.simulation
        assert (raw.get_sample_count(), raw.get_sample_range(), raw.get_all_samples()) == (0, None, [])
        assert raw.get_simulation_time_at_time((1, 2)) == 0.0


# -- class-level calls ---------------------------------------------------------------------------------------------


def test_the_managers_act_on_the_most_recently_entered_app():
    with App() as outer:
        with App() as inner:
            SimulationManager.setup_simulation(dt=1 / 240)
            RenderingManager.set_dt(1 / 30)
            assert inner.simulation.steps_per_second == 240
            assert outer.simulation.steps_per_second == 60
            assert SimulationManager._simulation_manager_interface is inner.simulation
        assert SimulationManager.get_physics_dt() == 1 / 60
        assert RenderingManager.get_dt() == 1 / 60
        assert "setup_simulation" in dir(SimulationManager)


def test_the_managers_say_that_there_is_no_app():
    with pytest.raises(UserError, match=r"with App\(\.\.\.\)"):
        SimulationManager.step()
