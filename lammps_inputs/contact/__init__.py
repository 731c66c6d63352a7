"""Contacts: their law, dents from before the run, and static loads."""
