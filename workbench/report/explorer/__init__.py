"""The explorer: one HTML page over the stored answers of a study, beside its report."""
