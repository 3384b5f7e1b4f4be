"""`graph doctor --device`: the card, its memory, and whether it measures what the processor measures."""

from __future__ import annotations

from graph.base.errors import UserError

from .printing import say, say_json

GIB = 2**30


def run(name: str, *, as_json: bool) -> int:
    """Checks a device; returns 0 if rays can be cast there, else 1. Raises UserError if it is missing."""
    from graph.sim.devices import plugin_of, warp

    if name == "cpu":
        raise UserError("doctor --device cpu: the processor needs no check of its own; name cuda, cuda:N or warp-cpu")
    plugin, wp = plugin_of(name), warp()
    device, found = plugin.device_of(name), plugin.compare(name)
    facts = {
        "device": device.name,
        "warp": wp.config.version,
        "ready": found.same,
        "rays": found.rays,
        "range_difference_m": found.worst_m,
        "other_surfaces": found.others,
    }
    if device.is_cuda:
        driver = wp.get_cuda_driver_version()
        facts |= {
            "driver": ".".join(map(str, driver)) if isinstance(driver, tuple) else str(driver),
            "memory_gib": round(device.total_memory / GIB, 1),
            "free_gib": round(device.free_memory / GIB, 1),
        }
    if as_json:
        say_json(facts)
        return 0 if found.same else 1
    memory = (
        f", {facts['free_gib']} of {facts['memory_gib']} GiB free, CUDA {facts['driver']}" if device.is_cuda else ""
    )
    say(f"{name}  {device.name}{memory}, Warp {wp.config.version}")
    say(f"{found.rays:,} rays as on the processor: ranges within {found.worst_m:.1e} m, other surfaces: {found.others}")
    say("ready" if found.same else "not ready: it measures something else; report it with this output")
    return 0 if found.same else 1
