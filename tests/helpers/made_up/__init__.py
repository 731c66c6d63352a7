"""Results, cases and files with known numbers, made up for tests."""
