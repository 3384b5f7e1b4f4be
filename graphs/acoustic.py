"""A parking sensor: two ultrasonic mounts in front of a wall, `python graphs/acoustic.py`.

Prints, for each signal way, the echoes that it hears: how far the way is and how strong.
"""

from __future__ import annotations

import numpy as np

from graph.sim import App
from sensors import parse_generic_model_output_data
from wings.acoustic import Acoustic, AcousticSensor

PREFIX = "omni:sensor:WpmAcoustic:"
SPEED_OF_SOUND = 343.0
ATTRIBUTES = {
    f"{PREFIX}centerFrequency": 51200.0,
    f"{PREFIX}pulseDuration": 5e-4,
    f"{PREFIX}sensorMount:m001:position": (0.0, -0.25, 0.0),
    f"{PREFIX}sensorMount:m002:position": (0.0, 0.25, 0.0),
    f"{PREFIX}rxGroup:g001:receiverIndices": [0, 1],
}
SCENE = {
    "/World/Ground": {"type": "Plane"},
    "/World/Wall": {"type": "Cube", "size": 1.0, "scale": [0.2, 6.0, 2.0], "translate": [3.1, 0, 1]},
    "/World/Post": {"type": "Cube", "size": 0.06, "scale": [1, 1, 30], "translate": [1.53, -0.25, 0.9]},
}


def main() -> None:
    """Measures once and prints the echoes."""
    with App(physics_hz=240, loop_hz=60) as app:
        app.add_prims(SCENE)
        acoustic = Acoustic(
            *("/World/Sonar",),
            aux_output_level="BASIC",
            tick_rate=30.0,
            attributes=ATTRIBUTES,
            translations=[0, 0, 0.5],
            app=app,
        )
        sensor = AcousticSensor(acoustic, annotators=["generic-model-output"])
        app.play()
        app.update(steps=2)
        gmo = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
        config = acoustic.config
        times = np.arange(gmo.numSamplesPerSgw) * config.sample_duration - config.pulse_duration / 2
        for number in range(gmo.numSgws):
            way = slice(number * gmo.numSamplesPerSgw, (number + 1) * gmo.numSamplesPerSgw)
            amplitude = gmo.scalar[way]
            sender, receiver = int(gmo.x[way][0]), int(gmo.y[way][0])
            echoes = [
                f"{SPEED_OF_SOUND * times[k] / 2:.2f} m ({amplitude[k]:.3f})"
                for k in range(1, len(amplitude) - 1)
                if amplitude[k] > 0.05 and amplitude[k - 1] < amplitude[k] >= amplitude[k + 1]
            ]
            print(f"mount {sender} to {receiver}: {', '.join(echoes)}")


if __name__ == "__main__":
    main()
