"""What the wing declares: the command `graph sweep`, and campaign files."""

from graph.cli.commands import Command
from graph.files.kinds import FileKind

SWEEP = Command("run graph files at many points, into one table", "wings.campaign.sweep", settings=True)
CAMPAIGN = FileKind("campaign files of graph sweep", "run it by graph sweep", "wings.campaign.file_kind")
