"""Writers of a report: HTML, Markdown, PDF."""
