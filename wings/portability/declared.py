"""What the wing declares: the products of `graph check --target`."""

from graph.cli.targets import Target

TARGET = Target("wings.portability")
