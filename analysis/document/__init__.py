"""The parts that a report consists of: tables, cells, figures, notes."""
