"""The devices on which a test runs: Warp's processor code everywhere, a card where there is one."""

import pytest

from graph.sim.devices import WARP_HOST, warp

DEVICES = [
    WARP_HOST,
    pytest.param("cuda", marks=pytest.mark.skipif(not warp().get_cuda_devices(), reason="no CUDA device is there")),
]
on_each = pytest.mark.parametrize("device", DEVICES)
