"""The asyncio loop of a script: made when it is needed, and then the current one."""

import subprocess
import sys

APP = "from isaacsim import SimulationApp\napp = SimulationApp({})\napp.update()\n"


def printed(tmp_path, text):
    """What a script prints in a process of its own."""
    file = tmp_path / "script.py"
    file.write_text(text)
    done = subprocess.run(
        [sys.executable, "-m", "graph", "exec", str(file)], capture_output=True, text=True, check=True, timeout=300
    )
    return done.stdout.split()


def test_a_script_without_coroutines_loads_neither_asyncio_nor_a_table_library(tmp_path):
    script = (
        f"{APP}import atexit, sys\natexit.register(lambda: print('asyncio' in sys.modules, 'rich' in sys.modules))\n"
    )
    assert printed(tmp_path, script + "app.close()\n") == ["False", "False"]


def test_tasks_made_at_top_level_run_in_the_loop_that_updates_turn(tmp_path):
    script = f"""{APP}
import asyncio, omni.kit.app
async def two_updates():
    for _ in range(2):
        await omni.kit.app.get_app().next_update_async()
    print("two")
task = asyncio.ensure_future(two_updates())
for _ in range(4):
    app.update()
print(task.done(), asyncio.get_event_loop() is task.get_loop())
app.close()
"""
    assert printed(tmp_path, script) == ["two", "True", "True"]


def test_a_snippet_that_awaits_before_it_imports_asyncio_has_one_loop(tmp_path):
    script = """
import omni.kit.app
await omni.kit.app.get_app().next_update_async()
import asyncio
async def task():
    print("ran")
asyncio.ensure_future(task())
"""
    assert printed(tmp_path, script) == ["ran"]


def test_a_task_that_fails_with_nobody_waiting_ends_the_script_with_its_line(tmp_path):
    """One that the script waited for itself is its own affair."""
    file = tmp_path / "script.py"
    file.write_text("""
import asyncio
import omni.kit.app
async def fails(word):
    await omni.kit.app.get_app().next_update_async()
    raise ValueError(word)
async def catches():
    try:
        await fails("caught")
    except ValueError as error:
        print(error)
asyncio.ensure_future(catches())
asyncio.ensure_future(fails("lost"))
""")
    command = [sys.executable, "-m", "graph", "exec", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stdout) == (1, "caught\n")
    assert f"graph: {file}:6: ValueError: lost" in done.stderr.splitlines()
    assert "Traceback" not in done.stderr
