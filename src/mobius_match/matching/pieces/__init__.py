"""Several pieces of one file: those that both shapes have are matched, the others ride along."""
