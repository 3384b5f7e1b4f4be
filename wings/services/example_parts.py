"""What the examples of this wing's node types need besides defaults."""

from nodes.catalog.example_parts import Parts

PARTS = {
    "OgnROS2ServiceClient": Parts({"messagePackage": "std_srvs", "messageName": "SetBool"}),
    "OgnROS2ServiceServerRequest": Parts({"messagePackage": "std_srvs", "messageName": "SetBool"}),
}
