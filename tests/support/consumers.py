"""What a consumer does with messages of a moving sensor: it places their points by TF as of their times."""

import numpy as np

from graph.sim.transforms import rotation_matrices, slerp


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def placed(sink, header, points, at):
    """(n, 3) points in the world: those of a header's frame by TF at their times `at` (n,) [s].

    None where TF does not reach to both sides of all times: a consumer waits for it.
    """
    if header.frame_id == "world":
        return points
    turns, origin = poses(sink, header.frame_id, at)
    return None if turns is None else np.einsum("nij,nj->ni", turns, points) + origin


def poses(sink, frame, at):
    """(n, 3, 3) rotations and (n, 3) origins [m] of a frame in the world at times (n,) [s]; None, None beyond TF."""
    sent = [one for sent in sink["/tf"] for one in sent.message.transforms if one.child_frame_id == frame]
    assert sent, f"no transform of {frame}"
    times = np.array([seconds(one.header.stamp) for one in sent])
    moves = [one.transform for one in sent]
    positions = np.array([[one.translation.x, one.translation.y, one.translation.z] for one in moves])
    rotations = np.array([[one.rotation.w, one.rotation.x, one.rotation.y, one.rotation.z] for one in moves])
    if at.min() < times[0] or at.max() > times[-1]:
        return None, None
    first = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    share = (at - times[first]) / (times[first + 1] - times[first])
    turns = rotation_matrices(slerp(rotations[first], rotations[first + 1], share))
    return turns, positions[first] + share[:, None] * (positions[first + 1] - positions[first])


def columns(cloud):
    """The points of a PointCloud2 as a structured array."""
    formats = [{4: "<u2", 6: "<u4", 7: "<f4"}[field.datatype] for field in cloud.fields]
    layout = {"names": [field.name for field in cloud.fields], "offsets": [field.offset for field in cloud.fields]}
    form = np.dtype({**layout, "formats": formats, "itemsize": cloud.point_step})
    return np.frombuffer(cloud.data.tobytes(), form)


def xyz(data):
    """(n, 3) coordinates of a structured array [m]."""
    return np.stack([data[axis] for axis in "xyz"], axis=1).astype(float)
