"""Plays the beginning of a `graph run` and keeps it, so that runs forked from this process find everything loaded."""

from __future__ import annotations

import argparse
import time
from typing import Any

from graph.cli import run
from graph.cli.arguments import asset_roots_of, limits_of, session_of
from graph.cli.main import split_settings

MOST_UPDATES, MOST_S = 60, 20.0
"""The longest rehearsal: updates, and wall time after the first of them [s]."""

EMPTY = "tickgraph: 1\nscene: {prims: {/World/Ball: {type: Sphere, rigid_body: true}}}\n"

_kept: list[Any] = []
"""Open sessions: they hold layers, structures and loops as long as the process lives."""


def rehearse(arguments: list[str], *, play: bool) -> None:
    """Opens the file of a command line `run FILE ...`; with `play` until each sensor rendered. Raises as a run does.

    Code of the user's own, of `--nodes` and `--allow-scripts`, is not run: it may start threads. Without a command
    line, and instead of such a file, an empty world is opened, which loads the libraries.
    """
    from graph.base.asset_roots import mapped
    from graph.base.limits import raised
    from graph.files import loads
    from graph.node import registry
    from graph.session.open import open_session
    from graph.sim.messages.bus import CountingSink
    from graph.sim.usd import Work

    Work.SetConcurrencyLimit(1)
    if not _kept:
        registry.all()
        _kept.append(open_session(loads(EMPTY)))
        _kept[0].app.play()
        _kept[0].app.update()
    if not arguments:
        return
    rest, settings = split_settings(arguments[1:])
    parser = argparse.ArgumentParser()
    run.add_arguments(parser)
    args = parser.parse_args(rest)
    if args.node_files or args.allow_scripts or args.play:
        return
    with raised(limits_of(args)), mapped(asset_roots_of(args)):
        session = session_of(args, settings=settings, seed=args.seed)
        app = session.app
        _kept.append(session)
        if not play:
            return
        app.bus.subscribe(CountingSink())
        app.play()
        began = time.monotonic()
        for _ in range(MOST_UPDATES):
            app.update()
            products = app.rendering.products.values()
            if (products and all(one.frames for one in products)) or time.monotonic() - began > MOST_S:
                break
