"""A graph file's content as plain data (`file_spec`), and the upgrade of old files (`migration`)."""
