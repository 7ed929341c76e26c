"""What all models of frames share: structure, runs, snapshots, and where they stop applying."""
