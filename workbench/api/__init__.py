"""Desk of questions: one answer, several side by side, pictures of both, a study."""
