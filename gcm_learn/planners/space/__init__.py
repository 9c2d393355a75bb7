"""Planning for spatial arms: straight moves, and what searches are made of."""
