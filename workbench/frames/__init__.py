"""What all models of frames share: structure, runs, snapshots, and where they stop applying."""

from pathlib import Path

from workbench.responses import findings_in

finding = findings_in(Path(__file__).with_name("findings.toml"))
