"""What a person asks at a desk: one answer, several side by side, pictures of both, a study."""
