"""Work that other threads may take over: in order, once, also where no thread is free."""

import os
import subprocess
import sys
from threading import Event, get_ident

import pytest

from graph.base.work import begin, results
from tests.support.places import ROOT


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_results_come_in_the_order_of_the_work_whoever_does_it(threads):
    works = [begin(threads, lambda number=number: number**2) for number in range(20)]
    assert results(works) == [number**2 for number in range(20)]


def test_one_thread_works_at_once_and_another_beside_the_caller():
    done = []
    begin(1, lambda: done.append(get_ident()))
    assert done == [get_ident()]
    begun = Event()
    other = begin(2, lambda: begun.set() or get_ident())
    assert begun.wait(60)
    assert other.result() != get_ident()


def test_what_no_thread_is_free_for_is_done_once_by_the_one_who_asks():
    busy, begun, calls = Event(), Event(), []
    waiting = begin(2, lambda: begun.set() or busy.wait(60))
    assert begun.wait(60)
    work = begin(2, lambda: calls.append(get_ident()) or len(calls))
    assert [work.result(), work.result()] == [1, 1]
    assert calls == [get_ident()]
    busy.set()
    assert waiting.result()
    assert results([begin(2, lambda: len(calls))]) == [1]  # the thread has gone on, and did nothing twice


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_what_work_raises_reaches_each_that_asks_for_its_result(threads):
    works = [begin(threads, lambda by=by: 6 // by) for by in (3, 0, 2)]
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            results(works)
    assert [works[0].result(), works[2].result()] == [2, 3]


ENDS = """
import os, threading
from graph.base.work import begin, results
assert results([begin(2, lambda: 1), begin(2, lambda: 2)]) == [1, 2]
child = os.fork()
if not child:  # the threads of the parent are not there
    begun = threading.Event()
    begin(2, begun.set)
    raise SystemExit(0 if begun.wait(60) else 3)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
print("ended")
"""

KEEPS = """
import os, threading
from graph.base.work import begin, usable_cores
all_of_them = os.sched_getaffinity(0)
os.sched_setaffinity(0, {min(all_of_them)})
assert usable_cores() == 1
os.sched_setaffinity(0, all_of_them)
assert begin(0, lambda: 3).result() == 3
assert threading.active_count() == 1
print("ended")
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="forks, and binds a process to a core")
@pytest.mark.parametrize("code", [ENDS, KEEPS], ids=["a_fork_has_its_own", "a_process_on_one_core_keeps_to_it"])
def test_threads_end_with_the_process_and(code):
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("ended\n", 0), done.stderr
