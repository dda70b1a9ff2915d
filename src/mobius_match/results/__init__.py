"""What a match gives: data, and the files that hold it."""
