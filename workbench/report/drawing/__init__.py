"""Drawing, common parts of figures of a report: style, sheets, symbols, deformed shapes."""
