"""What is carried along a dense map."""
