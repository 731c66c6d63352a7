"""Keys of all files that a user writes: reference, sections, examples and JSON Schema."""
