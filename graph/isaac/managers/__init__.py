"""The world in Isaac Sim's names: App, its managers, physics scenes, loop runner and orchestrator."""
