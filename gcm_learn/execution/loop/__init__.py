"""Loops: agents give commands to plants, with the world as it is or as it is perceived."""
