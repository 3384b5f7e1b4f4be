"""What a graph file says, as plain data (`file_spec`), and how old files are brought up to date (`migration`)."""
