"""The tests of TickGraph; a package so that they can import `tests.support`. README.md says how they are laid out."""
