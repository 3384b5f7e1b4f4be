from graph.cli.report import table_of

SENSOR = {"tick_rate": 10.0, "due": 50, "frames": 50, "elements": 2_389_163}
REPORT = {
    "sensors": {
        "/World/Robot/Chassis/top_lidar": {**SENSOR, "first_frame_ns": 0, "last_frame_ns": 4_900_000_001},
        "/World/Warehouse/Robots/Carter_01/Chassis/front_lidar": {
            **SENSOR,
            "frames": 0,
            "first_frame_ns": None,
            "last_frame_ns": None,
        },
    },
    "topics": {"/top/points": {"type": "sensor_msgs/msg/PointCloud2", "messages": 50}},
    "timeline_time": 5.0,
    "simulation_time": 5.0,
    "external_time": 4.95,
    "updates": 300,
    "physics_steps": 1200,
    "silent": [],
    "timing_s": {},
    "wall_time_s": 1.0,
    "real_time_factor": 5.0,
    "loop_hz": "60",
    "wall_clock": {"kind": "virtual", "sim_per_wall": 1},
}


def test_at_80_columns_no_word_is_broken_and_stamps_are_exact_and_short():
    lines = [line.rstrip() for line in table_of(REPORT, 80)]
    assert max(map(len, lines)) <= 80
    assert [line.split() for line in lines if line.startswith((" /", "/"))] == [
        ["/World/Robot/Chassis", "10", "50", "of", "50", "2,389,163", "0", "4.900000001"],
        ["/top_lidar"],
        ["/World/Warehouse", "10", "0", "of", "50", "(silent)", "2,389,163", "-", "-"],
        ["/Robots/Carter_01"],
        ["/Chassis/front_lidar"],
        ["/top/points", "50", "sensor_msgs/msg/PointCloud2"],
    ]
