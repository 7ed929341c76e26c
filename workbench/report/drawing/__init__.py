"""What the figures of a report share: style, sheets, symbols of structures, deformed shapes."""
