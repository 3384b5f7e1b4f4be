"""The wings: plug-ins that ship with TickGraph. No module outside names them; see `graph.base.plugins`."""
