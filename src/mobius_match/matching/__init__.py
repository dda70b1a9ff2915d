"""The main jobs: two surfaces, a part and its whole, a surface and its mirror image."""
