"""Planning for spatial arms: straight moves, search over the joints, and fronts in space."""
