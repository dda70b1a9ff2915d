"""Landmarks: their files, and the constraints that known pairs put on a match."""
