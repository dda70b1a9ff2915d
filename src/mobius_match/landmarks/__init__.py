"""Points that users know: their files, and what follows from them for a match."""
