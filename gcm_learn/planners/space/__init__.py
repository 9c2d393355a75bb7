"""Planning for spatial arms: straight moves, and search over the joints."""
