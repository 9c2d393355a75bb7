"""Memory: catches that are kept, found again from a new situation alone, and bent to it."""
