"""What can be asked of a scene: distance, clearance, free intervals, the sweep of a motion."""
