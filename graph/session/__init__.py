"""From a graph file to a running App: this package joins files, engine, world, sensors and nodes."""
