"""Transfer of attributes and shapes along a dense map, and interpolation between two shapes."""
