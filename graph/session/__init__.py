"""From a graph file to a running App: the room that joins files, engine, world, sensors and nodes."""
