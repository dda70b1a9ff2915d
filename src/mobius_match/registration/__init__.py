"""Non-rigid registration of one surface to another, sparse and dense, and how far it can be trusted."""
