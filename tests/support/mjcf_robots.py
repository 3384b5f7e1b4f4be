"""MJCF models that the tests write: a quadruped of several files, and small ones for single questions."""

from __future__ import annotations

import struct
import zlib

import numpy as np

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def stl(points, faces):
    """A binary STL."""
    out = bytearray(b"\0" * 80 + struct.pack("<I", len(faces)))
    for face in faces:
        out += struct.pack("<12fH", 0, 0, 0, *np.asarray(points, np.float32)[list(face)].ravel(), 0)
    return bytes(out)


def png(grey):
    """A PNG of 8 bits a pixel."""
    rows, columns = grey.shape

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    raw = b"".join(b"\0" + bytes(row) for row in grey.astype(np.uint8))
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def write_quadruped(folder):
    """scene.xml, which includes robot.xml, which includes common/defaults.xml; meshes and a height field beside."""
    (folder / "common").mkdir()
    (folder / "assets").mkdir()
    (folder / "assets" / "hull.obj").write_text(TETRAHEDRON)
    cube = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    faces += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    (folder / "assets" / "foot.stl").write_bytes(stl(np.array(cube) * 0.02, faces))
    (folder / "assets" / "hills.png").write_bytes(png(np.random.default_rng(3).integers(0, 255, (7, 9))))
    (folder / "common" / "defaults.xml").write_text(DEFAULTS)
    (folder / "robot.xml").write_text(ROBOT)
    (folder / "scene.xml").write_text(SCENE)
    return folder / "scene.xml"


DEFAULTS = """<mujocoinclude>
  <default>
    <geom friction="0.8" solref=".01 1"/>
    <default class="leg">
      <joint axis="0 1 0" range="-60 60" damping="1" armature=".01"/>
      <geom type="capsule" size=".03" group="3"/>
      <position kp="60" kv="3" ctrlrange="-1 1"/>
    </default>
    <default class="visual"><geom group="2" contype="0" conaffinity="0" density="0"/></default>
  </default>
</mujocoinclude>
"""

ROBOT = """<mujoco model="quadruped">
  <!-- ------ made by hand ------ -->
  <compiler angle="degree" autolimits="true" meshdir="assets" inertiafromgeom="true" settotalmass="14"/>
  <include file="./common/defaults.xml"/>
  <asset>
    <mesh file="hull.obj" scale=".2 .2 .2"/>
    <mesh name="foot" file="foot.stl"/>
    <material name="shell" rgba=".2 .3 .4 1"/>
  </asset>
  <worldbody>
    <body name="torso" pos="0 0 .8" childclass="leg">
      <freejoint name="root"/>
      <geom type="box" size=".2 .1 .05"/>
      <geom class="visual" type="mesh" mesh="hull" material="shell" pos="0 0 .06"/>
      <geom class="visual" type="ellipsoid" size=".25 .12 .06"/>
      <site name="imu" pos="0 0 .05"/>
      <replicate count="2" offset="0.3 0 0" sep="_">
        <frame pos="-.15 .12 0">
          <body name="hip">
            <joint name="hip"/>
            <geom fromto="0 0 0 0 0 -.25"/>
            <body name="knee" pos="0 0 -.25">
              <joint name="knee" range="-120 0" ref="-20"/>
              <geom fromto="0 0 0 0 0 -.25"/>
              <geom name="foot" class="visual" type="mesh" mesh="foot" pos="0 0 -.25"/>
              <site name="toe" pos="0 0 -.27"/>
            </body>
          </body>
        </frame>
        <frame pos="-.15 -.12 0">
          <body name="right hip">
            <joint name="right hip"/>
            <geom fromto="0 0 0 0 0 -.5"/>
          </body>
        </frame>
      </replicate>
    </body>
  </worldbody>
  <tendon><fixed name="pair"><joint joint="hip_0" coef=".5"/><joint joint="hip_1" coef=".5"/></fixed></tendon>
  <equality><joint joint1="knee_0" joint2="knee_1"/></equality>
  <contact><exclude body1="torso" body2="knee_0"/></contact>
  <actuator>
    <position class="leg" name="knee" joint="knee_0"/>
    <position class="leg" joint="right hip_1"/>
    <velocity name="spin" joint="right hip_0" kv="4"/>
    <general name="pull" tendon="pair" gainprm="30" biastype="affine" biasprm="0 -30 -2"/>
  </actuator>
  <sensor><accelerometer name="felt" site="imu"/><jointpos name="bent" joint="knee_0"/></sensor>
</mujoco>
"""

SCENE = """<mujoco model="scene">
  <include file="robot.xml"/>
  <option timestep="0.004" integrator="implicitfast" cone="elliptic"/>
  <asset><hfield name="hills" file="hills.png" size="4 3 .4 .1"/></asset>
  <worldbody>
    <geom name="hills" type="hfield" hfield="hills" pos="0 0 -.1"/>
    <body name="lift" mocap="true" pos="2 0 1"><geom type="cylinder" size=".2 .1"/></body>
    <body name="post" pos="-2 1 0" euler="0 0 30">
      <geom type="cylinder" size=".1 .5" pos="0 0 .5"/>
      <body name="arm" pos="0 0 1.1">
        <joint name="swing" axis="0 0 1"/>
        <geom type="capsule" size=".05" fromto="0 0 0 .6 0 0"/>
      </body>
    </body>
    <body name="ball" pos="0 1 2"><freejoint/><geom size=".15" mass="1" group="1"/></body>
  </worldbody>
  <actuator><motor name="swing" joint="swing" gear="5" ctrlrange="-2 2"/></actuator>
  <keyframe><key name="home" qpos="0 0 .9 1 0 0 0 .1 -.2 .3 .4 -.2 .2 .5 0 1 3 1 0 0 0" ctrl=".1 .2 0 0 .5"/></keyframe>
</mujoco>
"""


class Walker:
    """A walking robot as its makers' models are: a free base whose links follow one another on hinges, a weld each for
    the feet, position or force drives, and geoms that only show beside those that collide.

    text: the model; links: (name, parent) without the base; joints: (name, link) in the model's order.
    """

    def __init__(self, name, base, limbs, *, feet=(), actuator="position"):
        """limbs: rows of (link, joint, place, axis), each link on the one before; feet: links with a foot welded on."""
        self.base, self.links, self.joints = base, [], []
        bodies = ""
        for limb in limbs:
            parent, end = base, ""
            for link, joint, place, axis in limb:
                self.links.append((link, parent))
                self.joints.append((joint, link))
                bodies += f'<body name="{link}" pos="{place}"><joint name="{joint}" axis="{axis}"/>{SHAPES}'
                end, parent = "</body>" + end, link
                if link in feet:
                    foot = link.replace("calf", "foot")
                    self.links.append((foot, link))
                    bodies += f'<body name="{foot}" pos="0 0 -0.2">{SHAPES}</body>'
            bodies += end
        drive = {"position": 'kp="80" kv="4"', "motor": 'ctrlrange="-40 40"'}[actuator]
        drives = "".join(f'<{actuator} name="drive-{one}" joint="{one}" {drive}/>' for one, _ in self.joints)
        self.text = WALKER.format(name=name, base=base, shapes=SHAPES, bodies=bodies, drives=drives)


SHAPES = '<geom class="visual"/><geom class="collision"/>'
WALKER = """<mujoco model="{name}">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <joint damping="0.5" armature="0.01" frictionloss="0.1" range="-2 2"/>
    <default class="visual">
      <geom type="sphere" size="0.03" group="2" contype="0" conaffinity="0" density="0"/>
    </default>
    <default class="collision"><geom type="capsule" size="0.02 0.02" group="3"/></default>
  </default>
  <worldbody>
    <body name="{base}" pos="0 0 2"><freejoint/><site name="imu" pos="0 0 0.1"/>{shapes}{bodies}</body>
  </worldbody>
  <actuator>{drives}</actuator>
</mujoco>
"""


def quadruped_of_twelve_joints():
    """Go2's links and joints: base, and hip, thigh, calf and foot of four legs."""
    legs = [
        [
            (f"{leg}_hip", f"{leg}_hip_joint", f"{x} {y} 0", "1 0 0"),
            (f"{leg}_thigh", f"{leg}_thigh_joint", f"0 {y} 0", "0 1 0"),
            (f"{leg}_calf", f"{leg}_calf_joint", "0 0 -0.2", "0 1 0"),
        ]
        for leg, x, y in (("FL", 0.2, 0.1), ("FR", 0.2, -0.1), ("RL", -0.2, 0.1), ("RR", -0.2, -0.1))
    ]
    return Walker("go2", "base", legs, feet={f"{leg}_calf" for leg in ("FL", "FR", "RL", "RR")}, actuator="motor")


def humanoid_of_29_joints():
    """G1's links and joints, written with the characters that USD names cannot have: six of each leg, three of the
    waist, seven of each arm.
    """
    axes = {"pitch": "0 1 0", "roll": "1 0 0", "yaw": "0 0 1"}

    def limb(side, parts, place, step):
        out = []
        for number, part in enumerate(parts):
            axis = axes[part.rpartition(".")[2]]
            out.append((f"{side}{part}.link", f"{side}{part}.joint", place if not number else step, axis))
        return out

    leg = ("hip.pitch", "hip.roll", "hip.yaw", "knee.pitch", "ankle.pitch", "ankle.roll")
    arm = ("shoulder.pitch", "shoulder.roll", "shoulder.yaw", "elbow.pitch", "wrist.roll", "wrist.pitch", "wrist.yaw")
    waist = limb("waist-", ("yaw", "roll", "pitch"), "0 0 0.1", "0 0 0.05")
    sides = (("left-", 0.1), ("right-", -0.1))
    legs = [limb(side, leg, f"0 {y} -0.1", "0 0 -0.12") for side, y in sides]
    arms = [limb(side, arm, f"0 {3 * y} 0.3", "0 0 -0.08") for side, y in sides]
    return Walker("g1", "pelvis", [*legs, waist, *arms])
