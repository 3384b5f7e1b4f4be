"""`python -m graph` is the command `graph`."""

from graph.cli.main import main

raise SystemExit(main())
