"""The intrinsic mirror symmetry of one surface."""
