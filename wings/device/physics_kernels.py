"""What a device does for the physics of many worlds, beside mujoco-warp's steps."""

# Warp reads the annotations of kernels, so they are evaluated.

from typing import Any

from graph.sim.devices import warp

wp: Any = warp()


@wp.kernel
def carry(
    positions: wp.array2d(dtype=wp.vec3),
    quaternions: wp.array2d(dtype=wp.quat),
    velocities: wp.array2d(dtype=wp.spatial_vector),
    centres: wp.array2d(dtype=wp.vec3),
    roots: wp.array(dtype=wp.int32),
    anchor: wp.vec3d,
    bodies: wp.array2d(dtype=wp.mat44d),
    linear: wp.array2d(dtype=wp.vec3d),
    angular: wp.array2d(dtype=wp.vec3d),
):
    """Poses of bodies about the anchor and their velocities, from MuJoCo's: body b is its body b + 1.

    MuJoCo's quaternions are w, x, y, z; its velocities hold at the centre of mass of each body's tree.
    """
    world, body = wp.tid()
    q = quaternions[world, body + 1]
    place = wp.vec3(positions[world, body + 1])
    turn = wp.quat_to_matrix(wp.quatd(wp.float64(q[1]), wp.float64(q[2]), wp.float64(q[3]), wp.float64(q[0])))
    at = wp.vec3d(place) - anchor
    bodies[world, body] = wp.mat44d(
        turn[0, 0],
        turn[0, 1],
        turn[0, 2],
        at[0],
        turn[1, 0],
        turn[1, 1],
        turn[1, 2],
        at[1],
        turn[2, 0],
        turn[2, 1],
        turn[2, 2],
        at[2],
        wp.float64(0.0),
        wp.float64(0.0),
        wp.float64(0.0),
        wp.float64(1.0),
    )
    twist = velocities[world, body + 1]
    spin = wp.vec3(twist[0], twist[1], twist[2])
    drift = wp.vec3(twist[3], twist[4], twist[5])
    lever = place - centres[world, roots[body + 1]]
    linear[world, body] = wp.vec3d(drift + wp.cross(spin, lever))
    angular[world, body] = wp.vec3d(spin)


@wp.kernel
def restore(mask: wp.array(dtype=wp.bool), first: wp.array2d(dtype=wp.float32), now: wp.array2d(dtype=wp.float32)):
    """Copies the rows of the worlds in a mask."""
    world, column = wp.tid()
    if mask[world]:
        now[world, column] = first[world, column]


@wp.kernel
def drive(
    positions: wp.array2d(dtype=wp.float32),
    velocities: wp.array2d(dtype=wp.float32),
    stiffness: wp.array2d(dtype=wp.float32),
    damping: wp.array2d(dtype=wp.float32),
    columns: wp.array(dtype=wp.int32),
    controls: wp.array2d(dtype=wp.float32),
):
    """The controls that drives make of their targets; gains (1 or w, j) by those of their actuators (`drives`)."""
    world, joint = wp.tid()
    stiff, damped = stiffness[world % stiffness.shape[0], joint], damping[world % damping.shape[0], joint]
    aim = stiff * positions[world, joint] + damped * velocities[world, joint]
    controls[world, columns[joint]] = aim
