"""What recorded messages hold: clouds, scans with their poses, images; and the names of files for topics."""
