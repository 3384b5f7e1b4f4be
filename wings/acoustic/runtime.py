"""An acoustic sensor at work: one firing sequence a frame."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from graph.sim.renderer.schedule import Tick
from sensors.gmo import ElementFlags
from sensors.output_frame import pose_of
from sensors.prim import path_number, unknown_attributes
from sensors.raycast.shared import cast_world
from sensors.runtime import Measurement, SensorRuntime

from .config import IGNORED, AcousticConfig, Way, read_config
from .fan import fan
from .names import FAMILIES, PREFIX, PRIM_TYPE
from .signals import Air, Beam, Lit, Scene, direct, echoes
from .waves import SPEED_OF_SOUND, Membrane, envelope

if TYPE_CHECKING:
    from pxr import Usd


class AcousticRuntime(SensorRuntime[AcousticConfig]):
    """The sensor of an acoustic prim.

    A frame is one firing sequence, which begins at the tick's update and meets the world as it is then. Its elements
    are samples, one block for each signal way: the envelope of what a mount hears. Raises UserError for a prim that is
    not an acoustic sensor or cannot be one.
    """

    type_name = PRIM_TYPE

    def read(self, prim: Usd.Prim) -> AcousticConfig:
        """The configuration that the prim describes."""
        ignored = [name for name in IGNORED if (one := prim.GetAttribute(PREFIX + name)) and one.HasAuthoredValue()]
        if ignored:
            self.scene.warn(
                "acoustic-attribute-ignored",
                self.path,
                f"{', '.join(ignored)}: no effect here; `graph help other-sensors` says what acoustic sensors model",
            )
        for name, reason in unknown_attributes(prim, PREFIX, FAMILIES):
            self.scene.warn("sensor-attribute-unknown", f"{self.path}.{name}", reason)
        return read_config(prim)

    @property
    def reach(self) -> float:
        """How far sound travels within its samples [m]."""
        return SPEED_OF_SOUND * self.config.samples * self.config.sample_duration

    def configure(self) -> None:
        """Prepares the fan, the wave and the arrays that are the same in every frame."""
        config = self.config
        self._air = Air(config.center_frequency)
        self._membrane = Membrane(config.membrane_diameter, self._air.wave_number)
        rays = fan(config.spans, config.counts)
        self._beams = {way.sender: Beam(rays, self._membrane) for way in config.ways}
        self._mounts = [pose_of(mount.position, mount.rotation) for mount in config.mounts]
        ways, samples = config.ways, config.samples
        self._same: dict[str, np.ndarray] = {
            "txMount": np.repeat(np.array([way.sender for way in ways], np.uint32), samples),
            "rxMount": np.repeat(np.array([way.receiver for way in ways], np.uint32), samples),
            "wayChannel": np.repeat(np.array([way.channel for way in ways], np.uint32), samples),
            "timeOffsetNs": np.repeat(np.array([way.time_ns for way in ways], np.int32), samples),
            "flags": np.full(len(ways) * samples, int(ElementFlags.VALID), np.uint8),
        }
        for array in self._same.values():
            array.setflags(write=False)

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        """The time of the firing sequence and of what is recorded after it."""
        return tick.time, tick.time + Fraction(self.config.duration_ns, 10**9)

    def measure(self, tick: Tick) -> Measurement:
        """What the mounts hear of one firing sequence."""
        config, wanted = self.config, self.channels()
        arrays = {name: array for name, array in self._same.items() if name in wanted}
        if "scalar" in wanted:
            arrays["scalar"] = self._amplitudes(tick)
        pose = self.pose(tick.poses)
        facts = {"numSgws": len(config.ways), "numSamplesPerSgw": config.samples}
        return Measurement(arrays, len(config.ways) * config.samples, (pose, pose), facts=facts)

    def _amplitudes(self, tick: Tick) -> np.ndarray:
        config, pose = self.config, self.pose(tick.poses)
        scene = Scene(cast_world(tick.scene), tick.poses, self.exclude)
        mounts = [pose @ mount for mount in self._mounts]
        lit: dict[int, Lit] = {}
        heard: dict[tuple[int, int], np.ndarray] = {}
        for way in config.ways:
            pair = way.sender, way.receiver
            if way.sender not in lit:
                lit[way.sender] = self._beams[way.sender].lit(scene, mounts[way.sender], self.reach)
            if pair not in heard:
                heard[pair] = self._heard(scene, lit[way.sender], mounts, way)
        amplitudes = np.concatenate([heard[way.sender, way.receiver] for way in config.ways])
        return (amplitudes + self._noise(len(amplitudes))).astype(np.float32)

    def _heard(self, scene: Scene, lit: Lit, mounts: list[np.ndarray], way: Way) -> np.ndarray:
        sender, receiver, config = mounts[way.sender], mounts[way.receiver], self.config
        is_sender = way.sender == way.receiver
        parts = [
            echoes(scene, self._air, self._membrane, lit, receiver, is_sender=is_sender),
            direct(scene, self._air, self._membrane, sender, receiver),
        ]
        delays, waves = (np.concatenate(both) for both in zip(*parts, strict=True))
        found = envelope(delays, waves, config.samples, config.sample_duration, config.pulse_duration)
        return np.asarray(np.sqrt(config.pulse_power) * found)

    def _noise(self, count: int) -> np.ndarray | float:
        """Equally likely amplitudes between noiseMin and noiseMax; they follow from seed, path and frame."""
        least, largest = self.config.noise
        if not largest:
            return 0.0
        path = path_number(self.path)
        seed = np.random.SeedSequence([self.scene.seed & (2**64 - 1), path, self._frames])
        return np.random.Generator(np.random.SFC64(seed)).uniform(least, largest, count)
