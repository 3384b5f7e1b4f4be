"""Drives many robots at once: a policy of torch reads each world's lidar and turns its wheels. Nothing is trained.

python graphs/worlds.py                 # 4,096 worlds on a CUDA GPU
python graphs/worlds.py 8 warp-cpu      # a few on the processor, to see it work
"""

import sys
import time
from pathlib import Path

import torch
import warp as wp

from graph.sim import Worlds

count = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
device = sys.argv[2] if len(sys.argv) > 2 else "cuda"
worlds = Worlds(Path(__file__).with_suffix(".yaml"), count=count, device=device, channels=["distance"])
lidar = worlds.lidars["/World/Robot/chassis/lidar"]
ranges = wp.to_torch(lidar.channels.distance)  # (worlds, rays) [m], on the device; each scan overwrites it
memory = ranges.device

layer = torch.nn.Sequential(torch.nn.LazyLinear(64), torch.nn.Tanh(), torch.nn.Linear(64, 2)).to(memory)


def drive(updates: int) -> None:
    """Lets the policy drive; in the middle half of the worlds start again."""
    for update in range(updates):
        worlds.step()
        if lidar.frame_id[0] >= 0:
            speeds = 5 + 5 * layer(ranges.clamp(max=10) / 10)  # (worlds, 2) of the left and the right wheel [rad/s]
            worlds.drive(velocities=speeds)
        if update == updates // 2:
            worlds.reset(torch.rand(count) < 0.5)
    torch.cuda.synchronize() if memory.type == "cuda" else None


with torch.no_grad():
    drive(12)  # compiles what is not compiled yet
    start = time.perf_counter()
    drive(120)
seconds = time.perf_counter() - start
print(f"{count:,} worlds, 120 updates (2 s of each): {seconds:.2f} s, {count * 2 / seconds:,.0f} x real time in all")
print("frames of the first worlds:", lidar.frame_id[:8].tolist(), "; room was enough:", worlds.overflow() == "")
