"""What the wing declares: the command `graph view`."""

from graph.cli.commands import Command

VIEW = Command("draw a recording: one HTML page and pictures", "wings.view.command")
