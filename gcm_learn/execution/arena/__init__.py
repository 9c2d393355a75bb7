"""Kinematic arms that act step by step: their world, their steps, their observations."""
