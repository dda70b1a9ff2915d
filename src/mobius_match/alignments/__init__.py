"""Candidate alignments of two surfaces, and the choice between them."""
