"""Strategies against each other: the same views, the same visits, the same tests, paired seeds."""
