"""Square packings that strikers hit."""
