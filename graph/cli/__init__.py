"""The command `graph`: one module a subcommand."""
