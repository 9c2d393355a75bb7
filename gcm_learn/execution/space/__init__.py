"""Arms in space that act step by step: their world, their steps, what they are told."""
