"""Reports on runs and scans: inputs -> `model` (sections, tables, figures) -> HTML, Markdown or
PDF.
"""
