"""The composite-chain source: its homogeneous chain, and chains with a section of other beads."""
