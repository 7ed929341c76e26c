"""Frame models of other authors (Heng 2017, section 2.2): plastic hinges, fibers at few points."""
