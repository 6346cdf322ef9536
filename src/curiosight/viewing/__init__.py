"""Pictures of results, and what is seen while they are made; nothing ever calls them."""
