"""What a radar is: its scan configurations, wave and detector, as one immutable value."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

from graph.base.errors import UserError
from graph.base.limits import allowed, most
from graph.base.records import dataclass, field

from .antenna import Pattern
from .aperture import HALF, Aperture
from .cells import Cells
from .chirps import LIGHT, Chirps
from .names import attribute_name

MOST_SCANS = 255
"""`scanIdx` is a byte."""

MOST_BOUNCES = 255
"""So is the number of faces on a way."""

WAVELENGTH_MM = 3.9
"""The documented example's, at 76.87 GHz."""

MOST_ANGLES = 100_000
"""Angle cells of an axis, so that the numbers of all cells fit into 64 bits; they take no memory."""


@dataclass(frozen=True, slots=True)
class ScanConfig:
    """One scan configuration: where a radar looks, its cells and its detector.

    Field names are the attributes `omni:sensor:WpmDmat:scan:<instance>:` in snake case, and so are their units; angles
    are half of the field of view. Defaults are the documented example's, less its velocity and angle noise of 0.
    datacube_mode: that of the radar if empty. Antenna tables: gains [dB] over azimuth and elevation. Chirps and arrays
    count in the mode WAVEFORM, in Hz, s and wavelengths; where one is 0 the other attributes decide.
    """

    name: str = "s001"
    max_range_m: float = 50.0
    max_az_ang_deg: float = 75.0
    max_el_ang_deg: float = 20.0
    rays_per_deg: float = 8.0
    elev_mode: str = "NO_EL"
    time_offset_usec: float = 0.0
    power_factor: float = 1.0
    bins_from_spec: bool = True
    range_res_m: float = 0.4
    vel_res_mps: float = 0.147
    bore_az_res_deg: float = 1.3
    bore_el_res_deg: float = 5.0
    r_bins: int = 112
    v_bins: int = 160
    az_bins: int = 12
    el_bins: int = 2
    en_ang_aliasing: bool = False
    det_val_from_bin_idx: bool = False
    cfar_rn_t: int = 1
    cfar_rn_g: int = 0
    cfar_vn_t: int = 1
    cfar_vn_g: int = 0
    cfar_azn_t: int = 1
    cfar_azn_g: int = 0
    cfar_eln_t: int = 1
    cfar_eln_g: int = 0
    cfar_min_val: float = 7e-17
    cfar_offset: float = 1.0
    cfar_noise_mean: float = 0.0
    cfar_noise_sdev: float = 0.0
    max_vel_mps_sequence: tuple[float, ...] = (50.0, 55.0)
    rcs_tuning_coefficients: tuple[float, ...] = (-12.0, 150.0, 0.0)
    azimuth_rad_noise_mean: float = 0.0
    azimuth_rad_noise_sdev: float = 0.0
    elevation_rad_noise_mean: float = 0.0
    elevation_rad_noise_sdev: float = 0.0
    velocity_noise_mean: float = 0.0
    velocity_noise_sdev: float = 0.0
    range_noise_mean: float = 0.0
    range_noise_sdev: float = 0.0
    datacube_mode: str = ""
    rx_antenna_az_deg: tuple[float, ...] = ()
    rx_antenna_el_deg: tuple[float, ...] = ()
    rx_antenna_co_gain: tuple[float, ...] = ()
    tx_antenna_az_deg: tuple[float, ...] = ()
    tx_antenna_el_deg: tuple[float, ...] = ()
    tx_antenna_co_gain: tuple[float, ...] = ()
    carrier_frequency: float = 0.0
    chirp_bandwidth: float = 0.0
    chirp_duration: float = 0.0
    chirp_repetition_time: float = 0.0
    frequency_step_between_chirps: float = 0.0
    fast_time_samples: int = 0
    fast_time_padding_samples: int = 0
    enable_range_aliasing: bool = False
    array_azimuth_elements: int = 0
    array_elevation_elements: int = 0
    azimuth_element_spacing: float = 0.0
    elevation_element_spacing: float = 0.0
    azimuth_padding_samples: int = 0
    elevation_padding_samples: int = 0
    aperture_window_azimuth: str = ""
    aperture_window_elevation: str = ""

    @property
    def wavelength(self) -> float:
        """[m] of its carrier; of the documented example without one."""
        return LIGHT / self.carrier_frequency if self.carrier_frequency else WAVELENGTH_MM * 1e-3

    @property
    def waveform(self) -> bool:
        """Whether its cube is that of sampled chirps."""
        return self.datacube_mode == "WAVEFORM"

    def chirps(self, unambiguous: float = 0.0) -> Chirps:
        """Its chirps, in a cycle with this unambiguous velocity [m/s]; 0: the first."""
        carrier = LIGHT / self.wavelength
        repetition = self.chirp_repetition_time or LIGHT / (4.0 * carrier * (unambiguous or self.cycles[0]))
        return Chirps(
            carrier,
            self.chirp_bandwidth or LIGHT / (2.0 * self._spec_ranges().width),
            repetition,
            self.chirp_duration,
            self.frequency_step_between_chirps,
            self.fast_time_samples,
            self.fast_time_padding_samples,
        )

    @property
    def cycles(self) -> tuple[float, ...]:
        """The unambiguous velocities [m/s] of its cycles, which take turns."""
        if self.waveform and self.chirp_repetition_time > 0:
            return (self.wavelength / (4.0 * self.chirp_repetition_time),)
        return self.max_vel_mps_sequence

    def pattern(self, side: str) -> Pattern | None:
        """The table of the gains of one side, "rx" or "tx"; None without any. Raises ValueError for a wrong one."""
        names = (f"{side}_antenna_{each}" for each in ("az_deg", "el_deg", "co_gain"))
        return Pattern.of_table(*(getattr(self, name) for name in names))

    def aperture(self, axis: str) -> Aperture | None:
        """Its array along an axis, "azimuth" or "elevation"; None without elements or outside WAVEFORM."""
        elements = getattr(self, f"array_{axis}_elements")
        if not self.waveform or not elements:
            return None
        spacing, padding = getattr(self, f"{axis}_element_spacing"), getattr(self, f"{axis}_padding_samples")
        return Aperture(elements, spacing or HALF, padding, getattr(self, f"aperture_window_{axis}"))

    @property
    def elevations(self) -> tuple[float, float]:
        """Lowest and highest elevation of the field of view [rad]."""
        high = math.radians(self.max_el_ang_deg)
        return (0.0 if self.elev_mode == "POS_EL" else -high), high

    @property
    def azimuth_limit(self) -> float:
        """Half the field of view in azimuth [rad]."""
        return math.radians(self.max_az_ang_deg)

    def ranges(self) -> Cells:
        """Range cells [m]."""
        sampled = self.waveform and (self.chirp_bandwidth or self.fast_time_samples)
        return self.chirps().ranges(self.max_range_m) if sampled else self._spec_ranges()

    def _spec_ranges(self) -> Cells:
        if self.bins_from_spec:
            return Cells.of_resolution(0.0, self.max_range_m, self.range_res_m)
        return Cells(0.0, self.max_range_m, self.r_bins)

    def velocities(self, unambiguous: float) -> Cells:
        """Velocity cells [m/s] of a cycle with this unambiguous velocity; their ends meet."""
        count = self.v_bins
        if self.bins_from_spec:
            count = Cells.of_resolution(-unambiguous, unambiguous, self.vel_res_mps).count
        return Cells(-unambiguous, unambiguous, count)

    def azimuths(self) -> Cells:
        """Azimuth cells, equal in the sine of the azimuth."""
        if array := self.aperture("azimuth"):
            return array.cells
        limit = math.sin(self.azimuth_limit)
        count = self.az_bins
        if self.bins_from_spec:
            count = Cells.of_resolution(-limit, limit, math.sin(math.radians(self.bore_az_res_deg))).count
        return Cells(-limit, limit, count)

    def heights(self) -> Cells:
        """Elevation cells, equal in the sine of the elevation; one where no elevation is measured."""
        low, high = map(math.sin, self.elevations)
        if self.elev_mode == "NO_EL":
            return Cells(low, high, 1)
        if array := self.aperture("elevation"):
            return array.cells
        count = self.el_bins
        if self.bins_from_spec:
            count = Cells.of_resolution(low, high, math.sin(math.radians(self.bore_el_res_deg))).count
        return Cells(low, high, count)

    def cells(self) -> int:
        """How many range and velocity cells its largest cycle has."""
        return self.ranges().count * max(self.velocities(v).count for v in self.cycles)

    def grid(self, rays: int | None) -> tuple[int, int]:
        """Rays across (azimuth) and up (elevation); rays: about how many in all, None for `raysPerDeg`."""
        low, high = self.elevations
        across, up = 2 * self.azimuth_limit, high - low
        each = math.sqrt(across * up / rays) if rays else math.radians(1.0 / self.rays_per_deg)
        return max(1, round(across / each)), max(1, round(up / each))

    def problems(self) -> Iterator[str]:
        """What no radar can have, one line each."""
        for one in dataclasses.fields(self):
            value = getattr(self, one.name)
            values = value if isinstance(value, tuple) else (value,)
            if any(isinstance(each, float) and not math.isfinite(each) for each in values):
                yield f"{attribute_name(one.name)} is not finite"
                return
        for name in _POSITIVE:
            if getattr(self, name) <= 0:
                yield f"{attribute_name(name)} must be above 0"
        for name in _DEVIATIONS:
            if getattr(self, name) < 0:
                yield f"{attribute_name(name)} is negative"
        if self.elev_mode not in ("FULL_EL", "POS_EL", "NO_EL"):
            yield f"elevMode = {self.elev_mode!r} is not one of FULL_EL, POS_EL, NO_EL"
        if self.datacube_mode not in ("", *_TOKENS["datacube_mode"]):
            yield f"datacubeMode = {self.datacube_mode!r} is not one of {', '.join(_TOKENS['datacube_mode'])}"
        for side in ("rx", "tx"):
            try:
                self.pattern(side)
            except ValueError as error:
                yield f"{side}AntennaCoGain: {error}"
        for axis in ("azimuth", "elevation"):
            if array := self.aperture(axis):
                yield from array.problems(axis)
            elif self.waveform and getattr(self, f"{axis}_padding_samples"):
                yield f"{axis}PaddingSamples needs array{axis.capitalize()}Elements"
        for name in ("bore_az_res_deg", "bore_el_res_deg"):
            if getattr(self, name) > 90:
                yield f"{attribute_name(name)} = {getattr(self, name):g} is beyond 90 deg"
        for name in ("max_az_ang_deg", "max_el_ang_deg"):
            if getattr(self, name) > 90:
                yield f"{attribute_name(name)} = {getattr(self, name):g} is beyond 90 deg; it is half the field of view"
        if not self.max_vel_mps_sequence or min(self.max_vel_mps_sequence) <= 0:
            yield "maxVelMpsSequence needs velocities above 0"
        elif self.waveform and not any(getattr(self, name) < 0 for name in _DEVIATIONS):
            yield from self.chirps(max(self.cycles)).problems()
        if self.time_offset_usec * 1000 >= 2**31:
            yield f"timeOffsetUsec = {self.time_offset_usec:g} does not fit; in ns it has 31 bits, 2.1 s"
        tuning = self.rcs_tuning_coefficients
        if len(tuning) != 3 or tuning[1] <= 0 or tuning[2] < 0:
            yield "rcsTuningCoefficients are three: a threshold [dBsm], a factor above 0, a noise scale from 0 on"

    def too_large(self, four: bool) -> Iterator[str]:
        """What would need more memory than is allowed, one line each; four: whether CFAR works on all axes."""
        across, up = self.grid(None)
        if across * up > most("radar.rays"):
            yield f"raysPerDeg {self.rays_per_deg:g} makes {across * up:,} rays; {allowed('radar.rays')}"
        if self.cells() > most("radar.cells"):
            yield f"it has {self.cells():,} range and velocity cells; {allowed('radar.cells')}"
        angles = self.azimuths().count, self.heights().count
        if max(angles) > MOST_ANGLES:
            yield f"it has {angles[0]:,} azimuth and {angles[1]:,} elevation cells; at most {MOST_ANGLES:,} of each"
        cells = self.cells() * angles[0] * angles[1]
        if four and (self.cfar_noise_mean or self.cfar_noise_sdev) and cells > most("radar.cells"):
            yield f"noise in its {cells:,} cells (cfarMode 4D) takes {8 * cells:,} bytes; {allowed('radar.cells')}"


@dataclass(frozen=True, slots=True)
class RadarConfig:
    """Everything that decides what a radar sends, and what it makes of what comes back.

    Field names are the attributes `omni:sensor:WpmDmat:` in snake case; scans: in the order in which they run, with the
    radar's mode where they give none, and its wavelength where no carrier of theirs counts;
    without_effect: the attributes that the prim gives and that are not modelled.
    Raises UserError, naming scan and field, for values no radar can have.
    """

    name: str = "Generic"
    wave_length_mm: float = WAVELENGTH_MM
    trace_tree_depth: int = 4
    instance_time_offset_usec: int = 5000
    datacube_mode: str = "FAST"
    cfar_mode: str = "2D"
    antenna_gain_mode: str = "COSINEFALLOFF"
    elements_coords_type: str = "SPHERICAL"
    output_frame_of_reference: str = "SENSOR"
    custom_frame_of_reference_trafo: tuple[float, ...] = ()
    scans: tuple[ScanConfig, ...] = field(default_factory=lambda: (ScanConfig(),))
    without_effect: tuple[str, ...] = ()

    @property
    def wavelength(self) -> float:
        """[m]."""
        return self.wave_length_mm * 1e-3

    def __post_init__(self) -> None:
        problems = [
            f"{attribute_name(name)} = {getattr(self, name)!r} is not one of {', '.join(tokens)}"
            for name, tokens in _TOKENS.items()
            if getattr(self, name) not in tokens
        ]
        if not 1e-2 <= self.wave_length_mm <= 1e3:
            problems.append(f"waveLengthMm = {self.wave_length_mm:g}; give 0.01 to 1000 mm")
        else:
            object.__setattr__(self, "scans", tuple(self._settled(scan) for scan in self.scans))
        if self.trace_tree_depth > MOST_BOUNCES:
            problems.append(
                f"traceTreeDepth = {self.trace_tree_depth:,}; at most {MOST_BOUNCES} reflections are followed"
            )
        trafo = self.custom_frame_of_reference_trafo
        if len(trafo) not in (0, 6) or not all(map(math.isfinite, trafo)):
            problems.append("customFrameOfReferenceTrafo is six finite numbers: x, y, z [m], roll, pitch, yaw [deg]")
        if not 1 <= len(self.scans) <= MOST_SCANS:
            problems.append(f"it has {len(self.scans)} scan configurations; 1 to {MOST_SCANS} fit")
        for scan in self.scans:
            wrong = list(scan.problems()) or list(scan.too_large(self.cfar_mode == "4D"))
            problems += [f"scan {scan.name}: {line}" for line in wrong]
        if problems:
            raise UserError(f"radar {self.name}: {'; '.join(problems)}")

    def _settled(self, scan: ScanConfig) -> ScanConfig:
        """A scan with what it takes from the radar."""
        mode = scan.datacube_mode or self.datacube_mode
        own = scan.carrier_frequency if mode == "WAVEFORM" else 0.0
        carrier = own or LIGHT / self.wavelength
        return dataclasses.replace(scan, datacube_mode=mode, carrier_frequency=carrier)


_POSITIVE = (
    *("max_range_m", "max_az_ang_deg", "max_el_ang_deg", "rays_per_deg", "power_factor", "cfar_min_val"),
    *("range_res_m", "vel_res_mps", "bore_az_res_deg", "bore_el_res_deg", "r_bins", "v_bins", "az_bins", "el_bins"),
)
_DEVIATIONS = (
    *("cfar_offset", "cfar_noise_mean", "cfar_noise_sdev", "time_offset_usec"),
    *("azimuth_rad_noise_sdev", "elevation_rad_noise_sdev", "velocity_noise_sdev", "range_noise_sdev"),
    *("carrier_frequency", "chirp_bandwidth", "chirp_duration", "chirp_repetition_time"),
)
_TOKENS = {
    "datacube_mode": ("FAST", "WAVEFORM"),
    "cfar_mode": ("2D", "4D"),
    "antenna_gain_mode": ("COSINEFALLOFF", "CONSTANT"),
    "elements_coords_type": ("SPHERICAL", "CARTESIAN"),
    "output_frame_of_reference": ("SENSOR", "WORLD", "CUSTOM"),
}
