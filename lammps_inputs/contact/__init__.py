"""Contacts: laws, initial dents and static loads."""
