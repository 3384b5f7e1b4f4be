"""What a node is: its declaration, the registry of types, the database and context that its compute sees."""
