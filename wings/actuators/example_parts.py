"""What the example of this wing's node type needs besides defaults."""

from nodes.catalog.example_parts import ARM, ROBOT, Parts

_ACTUATOR = (
    "{type: NewtonActuator, schemas: [NewtonPDControlAPI, NewtonMaxEffortClampingAPI], attributes: {newton:kp: 20, "
    "newton:kd: 2, newton:maxEffort: 5, newton:targets: " + ROBOT + "/joint}}"
)
PARTS = {
    "ArticulationActuators": Parts(
        {"robotPath": ROBOT, "feedforwardCommand": [1.0]}, {**ARM, f"{ROBOT}/Actuators/joint": _ACTUATOR}
    )
}
