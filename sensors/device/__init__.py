"""Ray casting, lidar frames and many worlds on a device of NVIDIA Warp: a CUDA GPU, or Warp's own processor code."""
