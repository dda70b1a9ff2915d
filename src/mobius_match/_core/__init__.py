"""Tools for all rooms that know nothing of meshes: compiled kernels, threads, processes, files, versions."""
