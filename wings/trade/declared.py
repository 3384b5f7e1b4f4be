"""What the wing declares: the command `graph trade`."""

from graph.cli.commands import Command

TRADE = Command("measure speed against accuracy over fidelity knobs", "wings.trade.command", settings=True)
