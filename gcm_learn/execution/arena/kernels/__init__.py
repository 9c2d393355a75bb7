"""Compiled steps and observations: world and rewards of all arms, and kernels by command."""
