"""Energy and forces of an impact: dissipation, the material that did it, and their laws."""
