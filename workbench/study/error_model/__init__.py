"""Error model: measured errors of models, what they depend on, and the advice that follows."""
