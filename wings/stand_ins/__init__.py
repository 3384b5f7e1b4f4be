"""Stand-ins for assets of Isaac Sim that are not downloaded."""
