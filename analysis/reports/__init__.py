"""One page about any runs and scans: inputs -> `model` (sections, tables, figures) -> HTML, Markdown or PDF."""
