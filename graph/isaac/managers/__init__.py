"""The world in Isaac Sim's names: App, its managers, physics scenes and loop runner."""
