"""What practice uses: estimates by hand, rules of codes, equivalent masses, catenaries."""
