"""Waves along chains and layers under a static force."""
