"""Live transports: Foxglove, Rerun, DDS and zenoh, each over the library of an extra of that name."""
