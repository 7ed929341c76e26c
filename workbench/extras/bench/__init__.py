"""The impact bench: cases with references, half of them sealed, and what anyone answered."""
