"""Where a ray meets a solid, and the normal there, on a device.

The formulas are those of `raycast.forms`, whose tuples and NumPy names Warp does not read; a test holds both to each
other.
"""

# Warp reads the annotations of kernels, so they are evaluated.

from typing import Any

from graph.sim.devices import warp
from sensors.raycast.forms import BALL, BOX, CYLINDER, FRUSTUM, SEAM
from sensors.raycast.triangles import SKIN as SKIN_M

wp: Any = warp()

INFINITE = wp.constant(wp.float64(wp.inf))
TINY = wp.constant(wp.float64(1e-300))
SKIN = wp.constant(wp.float64(SKIN_M))
EDGE = wp.constant(wp.float64(1.0 + SEAM))
IS_BALL, IS_BOX = wp.constant(BALL), wp.constant(BOX)
IS_CYLINDER, IS_FRUSTUM = wp.constant(CYLINDER), wp.constant(FRUSTUM)


@wp.func
def _within(a: wp.float64, b: wp.float64, c: wp.float64):
    """From where to where a t^2 + 2 b t + c <= 0, for a > 0; from inf to -inf where it never is."""
    square = b * b - a * c
    enter, leave = INFINITE, -INFINITE
    if square >= wp.float64(0.0):
        root = wp.sqrt(square)
        enter = -(root + b) / a
        leave = (root - b) / a
    return enter, leave


@wp.func
def _slab(start: wp.float64, ahead: wp.float64, half: wp.float64):
    each = wp.float64(1.0) / (ahead + TINY)
    span = wp.abs(each) * half
    middle = -each * start
    return middle - span, middle + span


@wp.func
def _ball(start: wp.vec3d, ahead: wp.vec3d):
    return _within(wp.dot(ahead, ahead), wp.dot(start, ahead), wp.dot(start, start) - wp.float64(1.0))


@wp.func
def _box(start: wp.vec3d, ahead: wp.vec3d):
    enter, leave = -INFINITE, INFINITE
    for axis in range(3):
        first, last = _slab(start[axis], ahead[axis], wp.float64(1.0))
        enter = wp.max(enter, first)
        leave = wp.min(leave, last)
    return enter, leave


@wp.func
def _cylinder(start: wp.vec3d, ahead: wp.vec3d, high: wp.float64):
    a = ahead[0] * ahead[0] + ahead[1] * ahead[1] + TINY
    b = start[0] * ahead[0] + start[1] * ahead[1]
    enter, leave = _within(a, b, start[0] * start[0] + start[1] * start[1] - wp.float64(1.0))
    first, last = _slab(start[2], ahead[2], high)
    return wp.max(enter, first), wp.min(leave, last)


@wp.func
def _side(t: wp.float64, start: wp.vec3d, ahead: wp.vec3d):
    """Whether a root lies between the ends of a frustum."""
    return wp.abs(start[2] + t * ahead[2]) <= EDGE


@wp.func
def _end(t: wp.float64, radius: wp.float64, start: wp.vec3d, ahead: wp.vec3d):
    """Whether a place lies on the disc at an end of a frustum."""
    x = start[0] + t * ahead[0]
    y = start[1] + t * ahead[1]
    return x * x + y * y <= radius * radius * EDGE


@wp.func
def _frustum(start: wp.vec3d, ahead: wp.vec3d, low: wp.float64, high: wp.float64):
    half = wp.float64(0.5)
    n = (high - low) * half
    level = (low + high) * half + n * start[2]
    a = ahead[0] * ahead[0] + ahead[1] * ahead[1] - (n * ahead[2]) * (n * ahead[2])
    c = start[0] * start[0] + start[1] * start[1] - level * level
    b = start[0] * ahead[0] + start[1] * ahead[1] - n * ahead[2] * level
    enter, leave = INFINITE, -INFINITE
    square = b * b - a * c
    if square >= wp.float64(0.0):
        root = wp.sqrt(square)
        if b < wp.float64(0.0):
            root = -root
        q = -(b + root)
        if a != wp.float64(0.0):
            t = q / a
            if _side(t, start, ahead):
                enter = wp.min(enter, t)
                leave = wp.max(leave, t)
        if q != wp.float64(0.0):
            t = c / q
            if _side(t, start, ahead):
                enter = wp.min(enter, t)
                leave = wp.max(leave, t)
    if ahead[2] != wp.float64(0.0):
        t = (wp.float64(-1.0) - start[2]) / ahead[2]
        if _end(t, low, start, ahead):
            enter = wp.min(enter, t)
            leave = wp.max(leave, t)
        t = (wp.float64(1.0) - start[2]) / ahead[2]
        if _end(t, high, start, ahead):
            enter = wp.min(enter, t)
            leave = wp.max(leave, t)
    return enter, leave


@wp.func
def _capsule(start: wp.vec3d, ahead: wp.vec3d, low: wp.float64, high: wp.float64):
    enter, leave = _cylinder(start, ahead, high)
    if not enter <= leave:
        enter = INFINITE
        leave = -INFINITE
    first, last = _ball(wp.vec3d(start[0], start[1], start[2] - low), ahead)
    enter = wp.min(enter, first)
    leave = wp.max(leave, last)
    first, last = _ball(wp.vec3d(start[0], start[1], start[2] - high), ahead)
    return wp.min(enter, first), wp.max(leave, last)


@wp.func
def meet_solid(kind: wp.int32, low: wp.float64, high: wp.float64, start: wp.vec3d, ahead: wp.vec3d):
    """Where a ray meets a solid, in lengths of its direction; inf: not at all. See `PlacedForms.meet`."""
    enter, leave = INFINITE, -INFINITE
    if kind == IS_BALL:
        enter, leave = _ball(start, ahead)
    elif kind == IS_BOX:
        enter, leave = _box(start, ahead)
    elif kind == IS_CYLINDER:
        enter, leave = _cylinder(start, ahead, wp.float64(1.0))
    elif kind == IS_FRUSTUM:
        enter, leave = _frustum(start, ahead, low, high)
    else:
        enter, leave = _capsule(start, ahead, low, high)
    found = INFINITE
    if leave >= enter and enter >= wp.float64(0.0):
        found = enter
    elif leave >= enter and leave >= SKIN:
        found = leave
    return found


@wp.func
def _sign(value: wp.float64):
    if value < wp.float64(0.0):
        return wp.float64(-1.0)
    return wp.float64(1.0)


@wp.func
def _frustum_normal(p: wp.vec3d, low: wp.float64, high: wp.float64):
    """Of the side or the end, whichever is nearer."""
    slope = (high - low) * wp.float64(0.5)
    radius = (low + high) * wp.float64(0.5) + slope * p[2]
    level = wp.sqrt(p[0] * p[0] + p[1] * p[1])
    n = wp.vec3d(p[0], p[1], -slope * level)
    if level == wp.float64(0.0) or wp.abs(wp.float64(1.0) - wp.abs(p[2])) < wp.abs(level - radius):
        n = wp.vec3d(wp.float64(0.0), wp.float64(0.0), _sign(p[2]))
    return n


@wp.func
def solid_normal(kind: wp.int32, low: wp.float64, high: wp.float64, p: wp.vec3d):
    """The outward normal at a place of a solid, in its own frame, of any length."""
    n = p
    if kind == IS_BOX:
        most = wp.max(wp.max(wp.abs(p[0]), wp.abs(p[1])), wp.abs(p[2]))
        n = wp.vec3d()
        for axis in range(3):
            if wp.abs(p[axis]) == most:
                n[axis] = _sign(p[axis])
    elif kind == IS_CYLINDER:
        n = _frustum_normal(p, wp.float64(1.0), wp.float64(1.0))
    elif kind == IS_FRUSTUM:
        n = _frustum_normal(p, low, high)
    elif kind != IS_BALL:  # a capsule: from the nearest place of its axis
        n = wp.vec3d(p[0], p[1], p[2] - wp.min(wp.max(p[2], low), high))
    return n
