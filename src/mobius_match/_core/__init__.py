"""What every room may use and what knows no mesh: compiled kernels, threads, processes, files, versions."""
