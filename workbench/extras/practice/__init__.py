"""Models of practice: estimates by hand, rules of codes, equivalent masses, catenaries."""
